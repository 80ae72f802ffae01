"""Distances from obstacles: of points, of logs and of runs without one, and as text."""

import math

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl import simulate, simulate_many
from wmr_ctrl.codegen.build import program_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.fields.units import length
from wmr_ctrl.report.run_rows import rows_of
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.results.obstacles import closest, distance, nearest
from wmr_ctrl.world.scenario import loads_scenario, override

TRIANGLE, CIRCLE = [[1, 0], [3, 0], [3, 3]], [-1.0, 0.0, 0.4]
SHORT = {"body.radius": 0.3, "clock.duration": 6.0}
ROBOT = "safe-simulation"
WALLED = """
[base]
kind = "velocity"
tau = [0.28, 0.28]
gain = [1.05, 0.95]
delay = 0.1
[body]
radius = 0.25
[limits]
v_u1 = [1.0, 2.0]
[clock]
control = 0.05
duration = 12.0
[filter]
kind = "governor"
tau = [0.15, 0.3]
gain = [0.9, 1.1]
d = [0.05, 0.05]
odometry = [0.02, 0.02]
delay = [0.1, 0.15]
changing = true
free_error = 0.02
rest = 1.0
[world]
wall = [[2.0, -2.0], [2.0, 2.0]]
[reference]
kind = "line"
speed = 0.8
[disturbance]
std = 0.0
"""
"""A base behind a filter that stops, which is asked to drive through a wall."""
SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


@pytest.mark.parametrize("shape", [SQUARE, SQUARE[2:] + SQUARE[:2], SQUARE[::-1]])
def test_distances_from_a_square_are_those_of_its_sides_and_corners(shape):
    points = np.array([[2.0, 0.5], [2.0, 2.0], [0.5, 0.75], [-3.0, -4.0], [1.0, 0.5]])

    assert distance(shape, *points.T) == pytest.approx([1.0, math.sqrt(2), -0.25, 5.0, 0.0])


def test_the_closest_of_all_is_named_with_its_point():
    points = np.array([[9.0, 9.0], [3.0, 0.5], [4.0, 3.5]])

    assert closest([SQUARE, (5.0, 3.5, 0.25)], points) == (0.75, 1, 2)
    assert closest([SQUARE, (5.0, 3.5, 0.25)], points[:2]) == (2.0, 0, 1)


def test_distances_of_expressions_are_those_of_numbers():
    rng, place = np.random.default_rng(2), ca.SX.sym("place", 2)
    corner = ((0.0, 3.0), (2.0, 3.0), (2.0, 5.0), (1.0, 4.0), (0.0, 5.0))
    points = np.vstack([rng.uniform(-2, 6, size=(500, 2)), rng.integers(-1, 6, size=(60, 2))])
    for shape in (SQUARE, corner, ((5.0, -2.0), (5.0, 2.0)), (3.0, 1.0, 0.5)):
        graph = ca.Function("away", [place], [distance(shape, place[0], place[1], ca)])
        assert graph(points.T).full()[0] == pytest.approx(distance(shape, *points.T), abs=1e-12)


def walled(**changes):
    given = {key.replace("__", "."): value for key, value in changes.items()}
    return override(loads_scenario(WALLED), given)


@pytest.mark.parametrize("shapes", [[CIRCLE], [TRIANGLE, CIRCLE]])
def test_runs_without_a_log_have_the_gap_of_the_log(shapes):
    changes = {**SHORT, "reference.keep_out": shapes}
    table = simulate_many(ROBOT, "prox", seeds=range(3), overrides=changes)
    runs = [simulate(ROBOT, "prox", seed=seed, overrides=changes) for seed in range(3)]

    assert table["least_gap"] == pytest.approx([nearest(run)[0] for run in runs], abs=1e-9)
    assert runs[0].summary()["least_gap"] == FIGURES["least_gap"].of(runs[0]) == nearest(runs[0])[0]
    assert (table["least_gap"] < 0).all() == (TRIANGLE in shapes)


def test_without_obstacles_there_is_no_gap_and_the_same_c():
    table = simulate_many(ROBOT, "prox", seeds=[0], overrides=SHORT)
    case = simulate(ROBOT, "prox", overrides=SHORT)

    assert np.isnan(table["least_gap"]).all()
    assert case.summary()["least_gap"] is None
    assert "nearest obstacle" not in dict(rows_of(case))
    assert "obstacle" not in case.explanation
    free = program_of(settle(walled(world__wall=[]), "kanayama"))
    assert "GAP" not in "".join(free.generated_watched.values())


def test_walls_elsewhere_are_other_loops():
    near, far = (
        program_of(settle(walled(world__wall=[[x, -2.0], [x, 2.0]]), "kanayama"))
        for x in (2.0, 3.0)
    )

    assert "GAP" in "".join(near.generated_watched.values())
    assert near.generated_watched != far.generated_watched


def test_a_filter_that_stops_says_before_what():
    run = simulate(walled(), "kanayama")
    gap, place, _ = nearest(run)
    told = {item.key: item.text for item in run.remarks}["filter-holds-back"]

    assert 0 < gap < 0.2
    assert place == 1
    assert run.summary()["filter_share"][1] == 0  # turns of 1e-34 rad/s that it lets go are none
    assert told.startswith(f"The filter stopped the robot {length(gap)} before obstacle 1")
    assert f"It came within {length(gap)} of obstacle 1. But" in run.explanation
    assert dict(rows_of(run))["nearest obstacle"].startswith(f"{gap:.4g} m, obstacle 1 at ")


def test_an_unfiltered_base_that_touches_the_wall_says_so():
    run = simulate(
        loads_scenario(WALLED[: WALLED.index("[filter]")] + WALLED[WALLED.index("[world]") :]),
        "kanayama",
    )
    told = {item.key: item.text for item in run.remarks}

    assert nearest(run)[0] < 0
    assert "into obstacle 1. Move the path away" in told["obstacle"]
    assert "it touched an obstacle" in run.explanation
    assert dict(rows_of(run))["nearest obstacle"].endswith(": TOUCHED")
