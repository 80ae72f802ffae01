"""A wheeled robot can follow the desired trajectories, and their velocities match their poses."""

import math

import casadi as ca
import numpy as np
import pytest

from tests.papers_robot import paper, paper_toml
from wmr_ctrl.world.references import reference_bounds, sample
from wmr_ctrl.world.references.waypoints import profile_of, waypoint_path
from wmr_ctrl.world.scenario import override

HOOK = "points = [[0, 0], [1, 0.2], [2, 1.5], [1, 2.5], [-0.5, 2], [-1, 0.5]]"
EIGHT = "points = [[0, 0], [1, 1], [2, 0], [1, -1], [0, 0], [-1, 1], [-2, 0]"
SIZED = "kind = 'waypoints', omega_max = 1.0, a_max = 0.2, alpha_max = 1.0"
LAPS = (
    "kind = 'lemniscate', size = 1.5, rate = 0.3",
    "kind = 'rounded-square', side = 3.0, corner = 0.8, speed = 0.2",
    f"{SIZED}, {HOOK}, at_end = 'loop', speed = 0.3",
    f"{SIZED}, {EIGHT}, [-1, -1]], at_end = 'loop', speed = 0.4",
)
ALL = (
    "kind = 'circle', radius = 2.0, rate = 0.1",
    "kind = 'circle', radius = 0.5, rate = -0.7",
    "kind = 'line', speed = 0.9, heading = 2.3, origin = [1.0, -2.0]",
    "kind = 'stop-and-go', radius = 1.0, speed = 1.2, period = 3.0",
    f"{SIZED}, {HOOK}, speed = 0.2",
    f"{SIZED}, {EIGHT}], at_end = 'continue', speed = 0.5",
    f"{SIZED}, {HOOK}, tolerance = 0.1, closed = true, speed = 0.2",
    *LAPS,
)


def along(reference):
    """The paper's robot on another reference."""
    return paper_toml(f"reference = {{{reference}}}")


def test_at_no_time_there_are_no_samples():
    assert sample(paper(), np.empty(0)).shape == (0, 7)


@pytest.mark.parametrize("reference", ALL)
def test_robot_can_follow_it_without_slipping(reference):
    """q_d' = H(theta_d) v_d, Eqs. (4)-(5), and v_d' is the rate of v_d, by exact derivatives.

    Tested at random times over three cycles of a reference, or over a minute.
    """
    scenario = along(reference)
    system, cycle = scenario.reference_kind.build(scenario), scenario.reference.cycle
    times = np.random.default_rng(0).uniform(0, 3 * min(cycle, 20.0), (1, 400))
    path, theta = system.y, system.y[2]
    moving = ca.vertcat(-ca.sin(theta) * path[3], ca.cos(theta) * path[3], path[4:])
    left = ca.jacobian(path[:5], system.u) - moving
    residual = ca.Function("residual", [system.u, system.p], [left])

    assert not system.state
    assert np.abs(np.asarray(residual(times, ca.DM(system.p0)))).max() < 1e-9


@pytest.mark.parametrize("reference, turns", list(zip(LAPS, (0, 1, 1, 0), strict=True)))
def test_orientation_counts_the_turns_of_a_lap(reference, turns):
    scenario = along(reference)
    start, end = sample(scenario, np.array([0.0, scenario.reference.cycle]))

    assert end[2] - start[2] == pytest.approx(2 * math.pi * turns, abs=1e-9)
    assert -math.pi <= start[2] <= math.pi


@pytest.mark.parametrize("reference", ALL)
def test_numbers_are_parameters_of_the_graph(reference):
    """A reference of the same structure has the same graph, so nothing recompiles."""
    scenario = along(reference)
    names = [name for name in ("rate", "speed") if hasattr(scenario.reference, name)]
    faster = {f"reference.{name}": 2 * getattr(scenario.reference, name) for name in names}
    other, times = override(scenario, faster), np.linspace(0, 20, 50)
    one, two = (item.reference_kind.build(item) for item in (scenario, other))
    shared = ca.Function("shared", [one.u, one.p], [one.y])

    found = np.asarray(shared(times[None], ca.DM(two.p0))).T
    assert found == pytest.approx(sample(other, times), rel=1e-14, abs=1e-15)


@pytest.mark.parametrize("reference", [f"{SIZED}, {EIGHT}]", LAPS[2]])
def test_waypoints_are_passed_in_order(reference):
    scenario = along(reference)
    path, profile = waypoint_path(scenario.reference), profile_of(scenario.reference)
    times = [profile.starts[np.searchsorted(profile.places, k - 1e-9)] for k in path.knots]
    points = np.array(scenario.reference.points)

    assert (np.diff(path.knots) > 0).all()
    places = sample(scenario, np.array(times))[: len(points), :2]
    np.testing.assert_allclose(places, points, atol=1e-9)


@pytest.mark.parametrize(
    "reference, bounds",
    [
        ("kind = 'circle', radius = 2.0, rate = 0.1", (0.2, 0.2, 0.1)),
        ("kind = 'circle', radius = 2.0, rate = -0.1", (-0.2, -0.2, 0.1)),
        ("kind = 'line', speed = 0.9", (0.9, 0.9, 0.0)),
        ("kind = 'stop-and-go', radius = 2.0, speed = 0.4, period = 10.0", (0.0, 0.4, 0.2)),
        # v1^2 = (a w)^2 (c^2 + (2 c^2 - 1)^2) with c = cos wt: least at c^2 = 3/8.
        ("kind = 'lemniscate', size = 2.0, rate = 0.1", (0.05 * 7**0.5, 0.2 * 2**0.5)),
    ],
)
def test_bounds_of_the_velocities(reference, bounds):
    found = reference_bounds(along(reference))[: len(bounds)]

    assert found == pytest.approx(bounds, rel=1e-5, abs=1e-12)
