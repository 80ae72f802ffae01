"""Figures of a run at the ends of their windows, at the goal, and of rises and weights."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.results.conftest import build
from wmr_ctrl.core.signals import GUARD_DIAGNOSTICS, Signal
from wmr_ctrl.results import Monitor, Rises, rises
from wmr_ctrl.results.measures import (
    arrival,
    change_rms,
    halving_time,
    saturated_share,
    settling_time,
    torque_change_rms,
    weight_norm,
)
from wmr_ctrl.results.remarks import CHATTER, HELD_BACK, OF_LIMIT
from wmr_ctrl.results.verdicts import Outlook


def known(run, tau_max, needed=1.0):
    """The run with theory's numbers about its scenario: its torque limit and the torques it
    needs.
    """
    vars(run)["outlook"] = Outlook(tau_max, (), exact_pose=False)
    vars(run)["needed"] = np.full((run.rows, 2), needed)
    return run


def arriving(x, goal=6.0, **more):
    """A run of 10 s whose desired motion reaches the goal (1, 0) at 6 s; the robot's path is
    given.
    """
    run = build(duration=10.0, control=0.1, x=x, x_d=1.0, **more)
    return replace(run, settings=replace(run.settings, arrival=goal, tolerance=0.05))


def test_half_the_distance_is_reached_at_half_of_it():
    x = np.array([2.0, 1.5, 1.0, 0.5, 1.0])

    assert halving_time(build(rows=5, duration=0.05, x=x)) == pytest.approx(0.02)
    assert halving_time(build(rows=2, duration=0.05, x=x[:2])) is None
    assert halving_time(build(rows=0, duration=0.05)) is None


@pytest.mark.parametrize("rows, end, there", [
    (100, None, 0.0), (100, 9.95, None), (62, 6.2, 0.0), (60, 6.0, None), (50, 5.0, None),
])  # fmt: skip
def test_only_who_lived_beyond_the_goals_time_has_arrived(rows, end, there):
    stop = {"stopped": (end, 1), "stop_reason": "diverged"} if end else {}
    run = arriving(1.0, rows=rows, monitor=Monitor((0.0, 0.0), **stop))

    assert arrival(run) == {"reference": 6.0, "robot": there}


def test_changes_of_torque_are_from_the_row_before_and_never_from_the_very_first():
    torque = np.array([[1.0, 1.0], [2.0, 5.0], [2.0, 2.0]])
    still = np.r_[9.0, np.zeros(9)]

    assert change_rms(torque, slice(1, 2)) == pytest.approx(np.sqrt((1 + 16) / 2))
    assert change_rms(torque, slice(2, 3)) == pytest.approx(np.sqrt(9 / 2))
    assert torque_change_rms(build(duration=0.1, tau_right=still)) == 0.0


def test_a_wheel_is_at_its_limit_there_and_nowhere_below_but_for_rounding():
    torque = np.tile([2.0, 2.0 * (1 - 1e-12), 2.0 * (1 - 1e-6), -2.0, 0.0], 4)
    run = build(duration=0.2, tau_left=torque)

    assert saturated_share(known(run, 2.0)) == pytest.approx(3 / 5)
    assert saturated_share(build()) is None


ALTERNATING = np.where(np.arange(800) % 2, 1.0, -1.0)
SWINGING = np.sin(2 * np.pi * np.arange(800) / 10)


def burst(place, size):
    """Burst of 39 samples around ``place``, among 800 of which the last 400 are judged."""
    return np.where(abs(np.arange(800) - place) < 20, size, 0) * ALTERNATING


def keys(run):
    return {item.key for item in run.remarks}


@pytest.mark.parametrize(
    "tau, limit, pushed, chatters",
    [  # ALTERNATING changes by twice its size, SWINGING swings by 0.71 of it
        (0.6 * ALTERNATING, np.inf, 0.0, True),
        (0.49 * ALTERNATING, np.inf, 0.0, False),
        (1.5 * SWINGING, np.inf, 0.0, True),
        (1.3 * SWINGING, np.inf, 0.0, False),
        (0.6 * ALTERNATING, 13.0, 0.0, False),
        (0.6 * ALTERNATING, 11.0, 0.0, True),
        (0.6 * ALTERNATING, np.inf, 1.3, False),
        (0.6 * ALTERNATING, np.inf, 1.1, True),
        (burst(600, 0.85), np.inf, 0.0, True),
        (burst(600, 0.7), np.inf, 0.0, False),
        (burst(200, 2.0), np.inf, 0.0, False),
    ],
)
def test_torques_chatter_beyond_what_motion_pushes_and_limit_allow(tau, limit, pushed, chatters):
    assert (CHATTER, OF_LIMIT) == (1.0, 0.1)
    noise = {"noise_right": pushed, "noise_left": -pushed}
    torque = {"tau_right": 1.0 + tau, "tau_left": 1.0 + tau}
    run = build(duration=8.0, **torque, **noise)

    assert ("chatter" in keys(known(run, limit))) is chatters


@pytest.mark.parametrize("peak, chatters", [(1.0, True), (10.0, False)])
def test_where_the_motion_needs_no_torque_a_trace_of_it_does_not_chatter(peak, chatters):
    torque = np.r_[peak, 4e-3 * ALTERNATING[1:]]
    run = build(duration=8.0, tau_right=torque, tau_left=torque)

    assert ("chatter" in keys(known(run, np.inf, 0.0))) is chatters


@pytest.mark.parametrize("share, told", [(HELD_BACK, True), (HELD_BACK - 0.05, False)])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_guard_that_acts_on_either_axis_holds_back(axis, share, told):
    clip = np.zeros((800, 2))
    clip[600 : 600 + round(200 * share), axis] = 1.0  # the drive is the last quarter
    run = build(duration=8.0, extra=GUARD_DIAGNOSTICS, labels={"guard": True}, clip_active=clip)

    assert ("guard-holds-back" in keys(known(run, np.inf))) is told


def test_the_robot_arrives_when_it_is_near_for_good():
    x = np.where(np.arange(100) < 30, 1.0, 0.5)  # passes by, leaves, and returns at 7.2 s
    x[72:] = 0.98
    run = arriving(x)

    assert arrival(build()) is None
    assert arrival(run) == {"reference": 6.0, "robot": pytest.approx(7.2)}
    assert "goal-not-reached" not in [remark.key for remark in run.remarks]


@pytest.mark.parametrize(
    "x, goal, words",
    [(0.5, 6.0, "0.5 m"), (1.0, 20.0, "clock.duration"), (1.0, 10.0, "no sample from then on")],
)
def test_a_goal_that_is_not_reached_is_said(x, goal, words):
    run = arriving(x, goal)

    assert arrival(run)["robot"] is None
    said = {remark.key: remark.text for remark in run.remarks}
    assert words in said["goal-not-reached"]


WEIGHTS = (Signal("W_norm", "1", "norm of the weights", 2),)


@given(values=st.lists(st.integers(-1000, 1000), min_size=100, max_size=100))
def test_rises_less_falls_are_the_change_over_the_run(values):
    up, down = rises(build(V1=values)), rises(build(V1=-np.array(values)))

    assert up.total - down.total == values[-1] - values[0]
    assert up.count + down.count == sum(a != b for a, b in pairwise(values))
    assert up.largest == max(0, *np.diff(values))


def test_rises_are_those_between_the_samples_of_the_window():
    stairs = np.where(np.arange(100) < 50, 0.0, 1.0)
    run = build(V1=stairs)

    assert rises(run, 0.49, 0.51) == Rises(1, 1.0, 1.0)
    assert rises(run, 0.0, 0.5) == rises(run, 0.5) == Rises(0, 0.0, 0.0)
    assert rises(run, 0.5, 1.2) is None


def test_weight_norms_at_the_end_and_at_their_largest():
    first = np.concatenate([np.arange(60.0), np.arange(40.0)])
    norms = np.stack([first, np.arange(100.0)], axis=1)
    found = weight_norm(build(extra=WEIGHTS, W_norm=norms))

    assert found == {"end": [39.0, 99.0], "largest": [59.0, 99.0]}
    assert weight_norm(build()) is None
    assert weight_norm(build(extra=WEIGHTS, rows=0)) is None


def test_the_settling_time_is_the_start_of_the_last_stay():
    away = np.ones(100)
    away[20:30] = away[70:] = 0.1

    assert settling_time(build(x=away), 0.1) == pytest.approx(0.7)
    assert settling_time(build(x=away), 0.09) is None
    assert settling_time(build(x=away), 1.0) == 0.0
    assert settling_time(build(x=np.nan), 1.0) is None
