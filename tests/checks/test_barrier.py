"""The strength of the barrier, and the robots that it cannot hold."""

from dataclasses import replace

import numpy as np
import pytest

from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.theory.checks.wrong_model import largest_pull, phases, velocity_error

MODEL = "model"


def test_pull_at_the_papers_start_is_that_of_its_auxiliary_velocity(loop):
    at = loop("mb")
    pull = largest_pull(at, next(phases(at.scenario)))

    assert at.start.v_c0 == pytest.approx([7.174, -3.020], abs=1e-3)
    assert pull[0] == pytest.approx(25.74, rel=1e-2)


@pytest.mark.parametrize("law", ["mb", "nn"])
def test_the_pull_is_the_same_in_either_direction(loop, law):
    own = Loop(loop(law).setup)
    phase = next(phases(own.scenario))
    pull = largest_pull(own, phase)
    for signs in ([-1.0, 1.0], [1.0, -1.0]):
        vars(own)["start"] = replace(own.start, v_c0=np.array(signs) * own.start.v_c0)

        assert largest_pull(own, phase) == pytest.approx(pull, rel=1e-12)


@pytest.mark.parametrize("start", [[1.3, 0.0], [-1.3, 0.0], [0.0, -2.0], [1.3, 2.0]])
def test_a_start_outside_the_limit_is_not_reported_as_pushed_through(told, start):
    outside = {"initial.velocity": start}
    warnings = told("mb", outside, scenario="far-start-friction-overestimated", key=MODEL)

    assert not any("cannot hold" in item.sentence for item in warnings)


def test_change_after_the_approach_cannot_push_through(told):
    late = {"changes": [{"t": 30.0, "mu": 0.0}], "clock.duration": 80}
    sentences = [w.sentence for w in told("mb", late, scenario="far-start", key=MODEL)]

    assert sentences
    assert not any("cannot hold" in sentence for sentence in sentences)


@pytest.mark.parametrize("share, pushed", [(0.98, True), (1.02, False)])
def test_the_approach_is_as_long_as_the_robot_takes_to_the_reference_at_v_u2(
    loop, told, share, pushed
):
    at = loop("mb", scenario="far-start-drop")
    approach = np.hypot(*at.start.e[:2]) / at.scenario.limits.v_u2[0]
    drop = {"changes": [{"t": round(share * approach, 2), "mu": 0.0}]}
    sentences = [w.sentence for w in told("mb", drop, scenario="far-start-drop", key=MODEL)]

    assert any("cannot hold" in sentence for sentence in sentences) is pushed


def test_switch_of_the_paper_leaves_the_model_based_law_behind(loop, told):
    at = loop("mb", scenario="paper-simulation")
    *_, heavy = phases(at.scenario)
    (warning,) = told("mb", scenario="paper-simulation", key=MODEL)

    assert velocity_error(at, heavy) == pytest.approx(-0.150, rel=4e-3)
    assert "95.6 N from 40 s on, but mb believes 39.2 N" in warning.sentence
    assert "0.015 m behind" in warning.sentence


def test_guard_holds_what_the_barrier_cannot(told):
    found = told("mb", {"guard.enabled": True}, scenario="far-start-friction-overestimated")

    assert not any("cannot hold" in warning.sentence for warning in found)


def test_the_wheels_pull_no_more_than_they_can(loop):
    weak = loop("prox", {"actuator.tau_max": 0.5})
    phase = next(phases(weak.scenario))
    robot = weak.scenario.robot
    free = largest_pull(loop("prox"), phase)

    assert (largest_pull(weak, phase) < free).all()
    braking = 2 * 0.5 / robot.r + 2 * robot.m * robot.g * robot.mu
    assert largest_pull(weak, phase)[0] <= braking
