"""Desired trajectories: what a wheeled robot can follow, and that the velocities belong to it."""

import math

import casadi as ca
import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.world.references import (
    Circle,
    Lemniscate,
    Line,
    RoundedSquare,
    StopAndGo,
    Waypoints,
    reference_bounds,
)
from wmr_ctrl.world.references import sample as sample_scenario
from wmr_ctrl.world.references.waypoints import profile_of, waypoint_path

SIZED = {"speed": 0.2, "omega_max": 1.0, "a_max": 0.2, "alpha_max": 1.0}
HOOK = ((0.0, 0.0), (1.0, 0.2), (2.0, 1.5), (1.0, 2.5), (-0.5, 2.0), (-1.0, 0.5))
EIGHT = ((0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (1.0, -1.0), (0.0, 0.0), (-1.0, 1.0), (-2.0, 0.0))
LAPS = (
    Lemniscate(size=1.5, rate=0.3),
    RoundedSquare(side=3.0, corner=0.8, speed=0.2),
    Waypoints(points=HOOK, at_end="loop", **SIZED | {"speed": 0.3}),
    Waypoints(points=(*EIGHT, (-1.0, -1.0)), at_end="loop", **SIZED | {"speed": 0.4}),
)
ALL = (
    Circle(radius=2.0, rate=0.1),
    Circle(radius=0.5, rate=-0.7),
    Line(speed=0.9, heading=2.3, origin=(1.0, -2.0)),
    StopAndGo(radius=1.0, speed=1.2, period=3.0),
    Waypoints(points=HOOK, **SIZED),
    Waypoints(points=EIGHT, at_end="continue", **SIZED | {"speed": 0.5}),
    Waypoints(points=HOOK, tolerance=0.1, closed=True, **SIZED),
    *LAPS,
)


def name_of(reference):
    return type(reference).__name__


def graph_of(reference):
    """Symbols t and p with the reference's expression, and the numbers of p."""
    scenario = paper(reference=reference)
    system = scenario.reference_kind.build(scenario)
    assert not system.state
    return system.u, system.p, system.y, ca.DM(system.p0)


def sample(reference, times):
    """A reference that is a function of time alone, at times (N,) [s]: (N, 7)."""
    return sample_scenario(paper(reference=reference), times)


def instants(reference, count=400, seed=0):
    """Random times over three cycles of a reference, or over a minute."""
    cycle = reference.cycle if math.isfinite(reference.cycle) else 20.0
    return np.sort(np.random.default_rng(seed).uniform(0, 3 * cycle, count))


def test_at_no_time_there_are_no_samples():
    assert sample_scenario(paper(), np.empty(0)).shape == (0, 7)


@pytest.mark.parametrize("reference", ALL, ids=name_of)
def test_robot_can_follow_it_without_slipping(reference):
    """q_d' = H(theta_d) v_d, Eqs. (4)-(5), and v_d' is the rate of v_d, by exact derivatives."""
    t, p, path, numbers = graph_of(reference)
    theta, v1, v2 = path[2], path[3], path[4]
    moving = ca.vertcat(-ca.sin(theta) * v1, ca.cos(theta) * v1, v2, path[5], path[6])
    residual = ca.Function("residual", [t, p], [ca.jacobian(path[:5], t) - moving])

    worst = np.abs(np.asarray(residual(instants(reference).reshape(1, -1), numbers))).max()
    assert worst < 1e-9


@pytest.mark.parametrize("reference, turns", list(zip(LAPS, (0, 1, 1, 0), strict=True)), ids=str)
def test_orientation_counts_the_turns_of_a_lap(reference, turns):
    start, end = sample(reference, np.array([0.0, reference.cycle]))

    assert end[2] - start[2] == pytest.approx(2 * math.pi * turns, abs=1e-9)
    assert -math.pi <= start[2] <= math.pi


def test_waypoints_are_passed_in_order():
    for reference in (
        Waypoints(points=EIGHT, **SIZED),
        Waypoints(points=HOOK, at_end="loop", **SIZED),
    ):
        path, profile = waypoint_path(reference), profile_of(reference)
        assert (np.diff(path.knots) > 0).all()
        points = np.array(reference.points)
        times = [profile.starts[np.searchsorted(profile.places, k - 1e-9)] for k in path.knots]
        places = sample(reference, np.array(times))[: len(points), :2]

        np.testing.assert_allclose(places, points, atol=1e-9)


@pytest.mark.parametrize(
    "reference, bounds",
    [
        (Circle(radius=2.0, rate=0.1), (0.2, 0.2, 0.1)),
        (Circle(radius=2.0, rate=-0.1), (-0.2, -0.2, 0.1)),
        (Line(speed=0.9), (0.9, 0.9, 0.0)),
        (StopAndGo(radius=2.0, speed=0.4, period=10.0), (0.0, 0.4, 0.2)),
        # v1^2 = (a w)^2 (c^2 + (2 c^2 - 1)^2) with c = cos wt: least at c^2 = 3/8.
        (Lemniscate(size=2.0, rate=0.1), (0.2 * math.sqrt(7) / 4, 0.2 * math.sqrt(2), None)),
    ],
    ids=str,
)
def test_bounds_of_the_velocities(reference, bounds):
    found = reference_bounds(paper(reference=reference))

    for value, expected in zip(found, bounds, strict=True):
        if expected is not None:
            assert value == pytest.approx(expected, rel=1e-5, abs=1e-12)
