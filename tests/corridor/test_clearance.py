"""Clearance of a path with its corridor and the robot's body from obstacles."""

import math

import pytest

from tests.papers_robot import safe
from tests.tables import changes
from wmr_ctrl import load_run, simulate
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.results.obstacles import nearest
from wmr_ctrl.theory.corridor.clearance import find_clearance
from wmr_ctrl.world.scenario import loads_scenario
from wmr_ctrl.world.scenario.toml_io import to_toml

CIRCLE, WALL = [0.0, 2.0, 0.5], [[2.6, -1.0], [2.8, -1.0], [2.8, 5.0], [2.6, 5.0]]


def placed(shapes, **others):
    """The guarded circle with radius 2 m about (0, 2), obstacles, and a body of 0.3 m."""
    told = {"reference.keep_out": shapes, "body.radius": 0.3, **others}
    return safe(told)


def test_clearance_of_a_circle_is_what_geometry_says():
    clear = find_clearance(placed([CIRCLE, WALL]), 0.01)

    assert clear.path == pytest.approx(0.6, abs=1e-3)
    assert clear.path <= 0.6
    assert clear.obstacle == 2
    assert clear.free == pytest.approx(clear.path - 0.3 - 0.01)
    assert clear.time == pytest.approx(20 * math.acos(0.0) / 2, abs=0.05)
    assert "stay free" in clear.sentence


@pytest.mark.parametrize(
    "shapes, corridor, words",
    [
        ([[0.0, 2.0, 1.8]], 0.01, "a robot that never left its path would touch it"),
        ([[0.0, 2.0, 2.1]], 0.01, "leads through obstacle 1"),
        ([[0.0, 2.0, 1.6]], None, "without a corridor of the run nothing is promised"),
        ([[0.0, 2.0, 1.695]], 0.01, "pushes may bring the body there"),
    ],
)
def test_what_is_not_free_is_said(shapes, corridor, words):
    assert words in find_clearance(placed(shapes), corridor).sentence


def test_without_obstacles_nothing_is_said():
    assert find_clearance(safe(), 0.01) is None


def test_obstacles_survive_toml_and_a_run_that_touches_one_says_so(tmp_path):
    scenario = placed(
        [CIRCLE, WALL], **changes("initial.pose = [2.4, 0.5, 0.0]; clock.duration = 2.0")
    )
    run = simulate(scenario, "prox")
    run.save(tmp_path / "run.npz")

    assert loads_scenario(to_toml(scenario)).reference == scenario.reference
    gap, place, time = nearest(run)
    assert (gap < 0, place) == (True, 2)
    assert "obstacle" in [item.key for item in run.remarks]
    assert nearest(load_run(tmp_path / "run.npz")) == (gap, place, time)


@pytest.mark.parametrize(
    "shapes, words",
    [
        ([[1.0, 2.0]], "a circle [x, y, r] or a polygon"),
        ([[1.0, 2.0, -1.0]], "r >= 0"),
        ([[[0.0, 0.0], [1.0], [1.0, 1.0]]], "a pair [x, y]"),
        (3.0, "an array of circles"),
        ([[[0, 0], [1, 1], [1, 0], [0, 1]]], "as those after corners 1 and 3 do"),
        ([[0.0, 0.0, math.nan]], "a finite number"),
    ],
)
def test_what_is_no_obstacle_is_refused(shapes, words):
    with pytest.raises(ScenarioError) as refused:
        placed(shapes)
    assert words in str(refused.value)


def test_obstacles_without_a_body_are_refused():
    with pytest.raises(ScenarioError, match=r"body\.radius is not stated"):
        safe({"reference.keep_out": [CIRCLE]})
