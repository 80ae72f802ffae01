"""Arrival: when desired motion and robot are at the goal, and what is said where they are not."""

from dataclasses import replace

import numpy as np
import pytest

from wmr_ctrl.results.measures import arrival


@pytest.fixture
def arriving(make_run):
    """A run of 10 s whose goal (1, 0) the desired motion reaches at 6 s, the robot as asked."""

    def build(x, goal=6.0, tolerance=0.05):
        run = make_run(duration=10.0, control=0.1, x=x, x_d=1.0)
        return replace(run, settings=replace(run.settings, arrival=goal, tolerance=tolerance))

    return build


def test_a_run_without_goal_has_no_arrival(make_run):
    assert arrival(make_run()) is None
    assert make_run().summary()["arrival"] is None


def test_the_robot_arrives_when_it_is_near_for_good(arriving):
    x = np.where(np.arange(100) < 30, 1.0, 0.5)  # passes by, leaves, and returns at 7.2 s
    x[72:] = 0.98
    run = arriving(x)

    assert arrival(run) == {"reference": 6.0, "robot": pytest.approx(7.2)}
    assert "goal-not-reached" not in [remark.key for remark in run.remarks]


@pytest.mark.parametrize(
    "x, goal, words",
    [(0.5, 6.0, "0.5 m"), (1.0, 20.0, "clock.duration"), (1.0, 10.0, "no sample from then on")],
)
def test_a_goal_that_is_not_reached_is_said(arriving, x, goal, words):
    run = arriving(x, goal)

    assert arrival(run)["robot"] is None
    said = {remark.key: remark.text for remark in run.remarks}
    assert words in said["goal-not-reached"]
