"""Speed profiles keep the limits along the path, waste little time, and end at rest."""

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.world.references import Waypoints
from wmr_ctrl.world.references import sample as sample_scenario
from wmr_ctrl.world.references.speed_profile import PathLimits, fastest
from wmr_ctrl.world.references.waypoints import waypoint_path

ZIGZAG = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.5), (4.0, 1.5), (4.5, -1.0))
FAST = {"points": ZIGZAG, "speed": 0.9, "omega_max": 0.7, "a_max": 0.4, "alpha_max": 0.6}
PATHS = (
    Waypoints(tolerance=0.15, **FAST),
    Waypoints(tolerance=0.15, at_end="loop", **FAST),
    Waypoints(at_end="continue", v_max=0.4, **FAST),
)


def sample(reference, times):
    return sample_scenario(paper(reference=reference), np.asarray(times, dtype=float))


def limits_of(reference):
    speed = reference.speed if reference.v_max is None else reference.v_max
    return np.array([speed, reference.omega_max, reference.a_max, reference.alpha_max])


@pytest.mark.parametrize("reference", PATHS, ids=["stop", "loop", "continue"])
def test_limits_are_kept_everywhere_and_one_of_them_nearly_met(reference):
    found = np.abs(sample(reference, np.linspace(0, reference.cycle, 20_011))[:, 3:7])

    shares = found / limits_of(reference)
    assert shares.max() <= 1 + 1e-3
    inner = shares[200:-200].max(axis=1)
    assert np.median(inner) > 0.85  # in a cell with a corner the limit is met at one place


def test_no_corner_is_cut_by_more_than_the_tolerance():
    for tolerance in (0.02, 0.15, 0.5):
        reference = Waypoints(points=ZIGZAG, tolerance=tolerance)
        found = sample(reference, np.linspace(0, reference.cycle, 4001))[:, :2]
        cuts = [np.hypot(*(found - corner).T).min() for corner in np.array(ZIGZAG[1:-1])]
        off = np.min([away(found, *pair) for pair in pairwise(ZIGZAG)], axis=0)

        assert max(cuts) <= tolerance * (1 + 1e-3)  # the samples miss the nearest place
        assert max(cuts) > min(0.9 * tolerance, 0.2)  # lines are too short for more than that
        assert off.max() <= tolerance * (1 + 1e-3)


def away(points, begin, end):
    """Distance of points (n, 2) from a straight piece."""
    begin, way = np.array(begin), np.subtract(end, begin)
    share = np.clip((points - begin) @ way / (way @ way), 0, 1)
    return np.hypot(*(points - begin - share[:, None] * way).T)


@pytest.mark.parametrize(
    "top, time", [(10.0, 2 * math.sqrt(4.0 / 0.5)), (0.4, 4.0 / 0.4 + 0.4 / 0.5)]
)
def test_a_straight_line_takes_as_long_as_a_triangle_or_a_trapezium_of_speed(top, time):
    """4 m at 0.5 m/s2, with and without a limit of the speed."""
    path = waypoint_path(Waypoints(points=((0.0, 0.0), (4.0, 0.0))))
    limits = PathLimits(speed=top, turning=1.0, acceleration=0.5, angular_acceleration=1.0)

    assert fastest(path, limits, rest=True, stop=True).duration == pytest.approx(time, rel=0.01)
