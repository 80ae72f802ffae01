"""Noise and drives, which the theorems leave out."""

from math import inf

import pytest

from tests.corridor.further import EXACT
from wmr_ctrl.cli.check_sentences import promise
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import grip_warnings, warnings_for
from wmr_ctrl.world.scenario import load_scenario

NOISE, TORQUE, DELAY = "disturbance.std", "actuator.tau_max", "actuator.delay"
PAPER, NOMINAL = "paper-simulation", "paper-simulation-nominal"
TURNED = {NOISE: 0.5, "initial.pose": [0.0, 0.0, 0.0]}
"""sqrt(2) 0.5/0.1 of both wheels, times half the track of 0.25 m."""
LATE = {"guard.enabled": True, DELAY: 0.02}


@pytest.mark.parametrize(
    "law, changes, scenario, key, said",
    [
        ("mb", {}, PAPER, NOISE, "unbounded"),
        ("nn", {}, PAPER, NOISE, "unbounded"),
        ("mb", {}, "far-start", NOISE, "pushes v1 with 14.1 N rms"),
        ("mb", {}, "far-start", NOISE, "at most 2.33 N"),
        ("mb", {NOISE: 0.5, "disturbance.truncate": 3}, NOMINAL, NOISE,
         "0.5 N m rms, cut at 3 times that"),
        ("mb", TURNED, NOMINAL, NOISE, "pushes omega with 1.77 N m rms"),
        ("mb", {}, NOMINAL, NOISE, None),
        ("pid", {}, "far-start", NOISE, None),
        ("mb", {TORQUE: 1.95}, NOMINAL, TORQUE, "Raise it above 1.96 N m."),
        ("mb", {TORQUE: 1.97}, NOMINAL, TORQUE, None),
        ("pid", {TORQUE: 3.0}, PAPER, TORQUE, "friction needs 95.6 N"),
        ("mb", {DELAY: 0.01}, NOMINAL, DELAY, ""),
        ("mb", {DELAY: 0.009}, NOMINAL, DELAY, None),
        ("mb", LATE, NOMINAL, DELAY, "The guard still keeps the limits"),
        ("mb", {**LATE, "actuator.lag": 0.02}, NOMINAL, DELAY, "The guard still keeps the limits"),
    ],
)  # fmt: skip
def test_what_no_theorem_covers_is_told_with_its_size(told, law, changes, scenario, key, said):
    found = [item.sentence for item in told(law, changes, scenario=scenario, key=key)]

    assert len(found) == (said is not None)
    assert all(said in sentence for sentence in found)


@pytest.mark.parametrize("law", ["pid", "mb"])
def test_guard_counts_on_bounded_noise(told, law):
    unbounded = {"guard.enabled": True, "disturbance.truncate": inf}
    (warning,) = told(law, unbounded, scenario="far-start")

    assert warning.key == "disturbance.truncate"
    assert warning.sentence.endswith("Set disturbance.truncate = 3 for a guarantee.")


def test_guard_and_bounded_noise_leave_nothing_to_say(told):
    bounded = {"guard.enabled": True, "disturbance.truncate": 3}

    assert told("pid", bounded, scenario="far-start") == []


def test_a_base_that_takes_velocities_gets_no_advice_on_torques_of_the_law():
    """What the law sends there is no torque, and the guard is refused."""
    free = {"filter.kind": "none", "initial.pose": [-2.0, -2.0, 0.0]}
    setup = settle(load_scenario("turtlebot3-burger", free), "pid")
    said = " ".join(str(item) for item in (*warnings_for(setup), *grip_warnings(setup)))

    assert "At its first sample" not in said
    assert "switch the guard on" not in said
    assert "set a filter.kind, or start nearer" in said


def test_a_filter_is_named_where_there_is_none():
    setup = settle(load_scenario("turtlebot3-burger", {**EXACT, "filter.kind": "none"}), "prox")
    (found,) = [item for item in warnings_for(setup) if item.key == "filter.kind"]

    assert 'Set filter.kind = "clip"; what [filter] has to state' in found.sentence
    assert 'Set filter.kind = "clip"; what [filter] has to state' in promise(setup)
