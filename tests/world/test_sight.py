"""Free distances ahead and behind against a sweep of many headings over many points of a wall."""

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.sight import free_distances, seen_from, way_to_point, way_to_wall

PLACES, HEADINGS = np.linspace(0, 1, 1501)[:, None], 301


def swept(points, window, radius, sense):
    """Least distance along any heading of the window before the disc covers one of the points."""
    ways = [np.inf]
    for heading in np.linspace(-window[1], window[0], HEADINGS):
        along = sense * np.array([np.cos(heading), np.sin(heading)])
        ahead, beside = points @ along, points @ (-along[1], along[0])
        met = (np.abs(beside) <= radius) & (ahead > 0)
        ways += [np.min(ahead[met] - np.sqrt(radius**2 - beside[met] ** 2))] if met.any() else []
    return min(ways)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_wall_is_met_where_a_sweep_meets_it(sense):
    draw, met = np.random.default_rng(4), 0
    for _ in range(60):
        a, b = draw.uniform(-2, 2, (2, 2))
        window, radius = draw.uniform(0, 1.5, 2), draw.uniform(0.1, 0.3)
        points = a + PLACES * (b - a)
        if np.hypot(*points.T).min() < radius:
            continue
        told = float(way_to_wall((a, b), window, radius, sense))
        way = swept(points, window, radius, sense)
        met += way < np.inf
        assert told == pytest.approx(way, abs=2e-3) if way < np.inf else told == LARGEST
    assert met > 20


def test_a_point_out_of_the_cone_is_never_met():
    assert float(way_to_point((0.0, 1.0), (0.2, 0.2), 0.3, 1)) == LARGEST
    assert float(way_to_point((-1.0, 0.0), (0.2, 0.2), 0.3, 1)) == LARGEST
    assert float(way_to_point((-1.0, 0.0), (0.2, 0.2), 0.3, -1)) == pytest.approx(0.7)
    assert float(way_to_point((0.1, 0.0), (0.2, 0.2), 0.3, 1)) == pytest.approx(-0.2)


def test_a_pose_sees_what_is_ahead_and_to_its_left():
    east = ca.SX([1.0, 2.0, -np.pi / 2])  # along +X
    assert [float(item) for item in seen_from(east, (3.0, 2.5))] == pytest.approx([2.0, 0.5])


def test_ways_are_those_to_the_nearest_shape():
    window, pose = (ca.SX(0.1), ca.SX(0.1)), ca.SX([0.0, 0.0, 0.0])  # along +Y
    wall, column = ((-1.0, 4.0), (1.0, 4.0)), (0.0, -2.0, 0.5)
    ahead, behind = free_distances([wall, column], pose, window, 0.25)
    assert (float(ahead), float(behind)) == pytest.approx((3.75, 1.25))
    assert float(free_distances([], pose, window, 0.25)[0]) == LARGEST
