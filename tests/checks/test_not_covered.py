"""Noise and drives, which the theorems leave out."""

import re
from math import inf

import pytest

from tests.corridor.further import EXACT
from wmr_ctrl.cli.check_sentences import promise
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import grip_warnings, warnings_for
from wmr_ctrl.world.scenario import load_scenario, override


@pytest.mark.parametrize("law", ["mb", "nn"])
def test_noise_leaves_no_guarantee(told, law):
    (warning,) = told(law, scenario="paper-simulation", key="disturbance.std")

    assert "unbounded" in warning.sentence


def test_noise_is_measured_against_the_barriers_pull(told):
    (warning,) = told("mb", scenario="far-start", key="disturbance.std")

    assert "pushes v1 with 14.1 N rms" in warning.sentence
    assert "at most 2.33 N" in warning.sentence


def test_bounded_noise_is_named_so(told):
    noise = {"disturbance.std": 0.5, "disturbance.truncate": 3}
    (warning,) = told("mb", noise, key="disturbance.std")

    assert "0.5 N m rms, cut at 3 times that" in warning.sentence


def test_noise_turns_by_the_arm_of_its_wheels(told):
    """Both wheels' torques, over r and by half the track: sqrt(2) 0.5/0.1 times 0.25 m."""
    turned = {"disturbance.std": 0.5, "initial.pose": [0.0, 0.0, 0.0]}
    (warning,) = told("mb", turned, key="disturbance.std")

    assert "pushes omega with 1.77 N m rms" in warning.sentence


@pytest.mark.parametrize(
    ("law", "scenario"), [("mb", "paper-simulation-nominal"), ("pid", "far-start")]
)
def test_silent_without_noise_and_for_laws_that_promise_nothing(told, law, scenario):
    assert told(law, scenario=scenario, key="disturbance.std") == []


@pytest.mark.parametrize(("tau_max", "warned"), [(1.95, True), (1.97, False)])
def test_torque_that_friction_uses_up(told, tau_max, warned):
    """The remedy names where that ends."""
    limited = {"actuator.tau_max": tau_max}
    found = told("mb", limited, key="actuator.tau_max")

    assert bool(found) is warned
    assert all("Raise it above 1.96 N m." in item.sentence for item in found)


def test_friction_after_a_change_counts_too(told):
    limited = {"actuator.tau_max": 3.0}
    (warning,) = told("pid", limited, scenario="paper-simulation", key="actuator.tau_max")

    assert "friction needs 95.6 N" in warning.sentence


@pytest.mark.parametrize(("delay", "warned"), [(0.009, False), (0.01, True)])
def test_delay_of_a_control_period(told, delay, warned):
    assert bool(told("mb", {"actuator.delay": delay}, key="actuator.delay")) is warned


@pytest.mark.parametrize(("lag", "kept"), [(0.0, True), (0.02, True)])
def test_behind_a_guard_a_delay_endangers_the_path_alone(told, lag, kept):
    late = {"guard.enabled": True, "actuator.delay": 0.02, "actuator.lag": lag}
    (warning,) = told("mb", late, key="actuator.delay")

    assert ("The guard still keeps the limits" in warning.sentence) is kept


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


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, 'Set filter.kind = "clip" or "governor".'),
        ({"base.tau": [0.3, 0.3]}, 'Set filter.kind = "clip".'),
        ({"base.gain": [1.2, 1.2]}, "what [filter] has to state for it is then named."),
    ],
)
@pytest.mark.slow
def test_a_filter_is_named_where_it_holds(changed, said):
    own = {**EXACT, "filter.kind": "none", **changed}
    setup = settle(load_scenario("turtlebot3-burger", own), "prox")
    (found,) = [item for item in warnings_for(setup) if item.key == "filter.kind"]

    assert said in found.sentence
    assert said in promise(setup)
    for kind in re.findall(r'"(clip|governor)"', said):
        settle(override(setup.scenario, {"filter.kind": kind}), "prox")
