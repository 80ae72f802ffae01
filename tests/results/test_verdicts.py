"""Verdicts: remarks on synthetic logs and on scenarios with known theory."""

from dataclasses import replace

import numpy as np
import pytest

from tests.results.conftest import build
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.results import tracked
from wmr_ctrl.results.measures import tracking
from wmr_ctrl.results.verdicts import CorridorLeft, Outlook, Warning

ROBOT = scenario_of("paper-simulation").robot


def keys(run):
    return {item.key for item in run.remarks}


def arriving(duration, x):
    """A run that rests at the goal from 4 s on; metrics.tolerance is 5 cm."""
    run = build(duration=duration, control=0.1, x=x)
    return replace(run, settings=replace(run.settings, arrival=4.0, tolerance=0.05))


@pytest.mark.parametrize("duration", [4.0, 5.0, 8.0, 80.0, 800.0])
def test_a_longer_rest_does_not_hide_an_error_of_the_drive(duration):
    t = 0.1 * np.arange(round(10 * duration))
    run = arriving(duration, np.where(t < 4.0, 0.06, 0.0))

    assert tracking(run)["drive"] == pytest.approx({"position_rms": 0.06, "position_max": 0.06})
    assert tracked(run) is False
    assert "not-tracked" in keys(run)


def test_drive_and_end_are_judged_apart_and_the_start_fades():
    t = 0.1 * np.arange(80)
    parted = np.select([t < 2.0, t < 4.0], [0.3, 0.01], 0.07)
    run = arriving(8.0, parted)

    assert tracking(run)["drive"] == pytest.approx({"position_rms": 0.01, "position_max": 0.01})
    assert tracking(run)["end"] == pytest.approx({"position_rms": 0.07, "position_max": 0.07})
    assert tracked(run) is False
    assert tracking(build())["end"] is None
    near = np.where(t < 2.0, 0.3, 0.01)
    assert tracked(arriving(8.0, near)) is True


def test_on_a_line_the_motion_needs_friction_half_at_each_wheel():
    """mu m g r/2 at constant speed; 20 % more after the later increase of mass."""
    line = {"reference.kind": "line", "changes": [{"t": 5.0, "m": 60.0}], "clock.duration": 10.0}
    run, robot = simulate("paper-simulation", "kanayama", overrides=line), ROBOT
    torque = robot.mu * robot.m * robot.g * robot.r / 2

    assert run.needed[0] == pytest.approx([torque, torque], rel=1e-6)
    assert run.needed[-1] == pytest.approx([1.2 * torque, 1.2 * torque], rel=1e-6)


def test_without_friction_the_motion_needs_what_accelerates_it():
    """Both wheels together m v1', their difference I omega'."""
    free = changes(
        "reference.kind = 'lemniscate'; reference.size = 2.0; reference.rate = 0.1;"
        "robot.mu = 0.0; changes = []; clock.duration = 1.0"
    )
    run, robot = simulate("paper-simulation", "kanayama", overrides=free), ROBOT

    right, left = run.needed.T / robot.r
    assert right + left == pytest.approx(robot.m * run["v1_d_dot"], rel=1e-6)
    assert robot.l * (right - left) == pytest.approx(robot.I * run["v2_d_dot"], rel=1e-6)
    assert abs(run["v2_d_dot"]).max() > 2 * abs(run["v1_d_dot"]).max() > 0


def test_gains_for_another_period_are_objected():
    run = simulate("safe-simulation", "prox", overrides={"clock.control": 0.1})
    text = next(item.text for item in run.remarks if item.key == "objected")

    assert "are lower, as `wmr-ctrl tune` finds them." in text
    assert "Nothing needs to be done" not in run.explanation


def test_a_run_of_an_unknown_law_is_not_said_to_be_checked():
    run = build(labels={"law": "theirs"})

    assert run.outlook is None
    assert "Nothing needs to be done" not in run.explanation


def test_torques_of_somebody_elses_law_are_judged_by_what_the_motion_needs():
    """Theory knows nothing of the law; motion, drives and sensors are those of the log."""
    told = {"actuator.tau_max": 6.0, "encoder.counts": 4096, "changes": []}
    run = simulate("safe-simulation", "pid", overrides={"clock.duration": 20.0, **told})
    calm = replace(run, law="Theirs")
    assert not calm.outlook.objections
    quiet = simulate("safe-simulation", "pid", overrides={"clock.duration": 20.0, "changes": []})
    assert quiet.explanation.endswith("Nothing needs to be done.")
    assert replace(quiet, law="Theirs").explanation.endswith("was not checked.")

    rng = np.random.default_rng(0)
    noise = {name: rng.normal(0.0, 5.0, run.rows) for name in ("tau_right", "tau_left")}
    loud = replace(calm, columns={**run.columns, **noise})
    full = replace(calm, columns={**run.columns, "tau_left": np.full(run.rows, 6.0)})
    assert "chatter" in keys(loud) - keys(calm)
    assert "saturated" in keys(full) - keys(calm)
    assert "exact-pose" in keys(calm)


def test_what_theory_says_is_a_sentence_with_its_place_and_only_some_of_it_objects():
    fault, limit = Warning("law", "a", "Eq. (9)"), Warning("law", "b", "Eq. (9)", objects=False)

    assert str(fault) == "a [Eq. (9)]"
    assert Outlook(1.0, (fault, limit), exact_pose=True).objections == (fault,)


def test_a_corridor_that_was_left_is_told_in_numbers():
    left = CorridorLeft(12.0, 0.0305, 0.02, 3.0, "dbar holds")

    assert left.sentence.startswith("At t = 12 s the robot was 30.5 mm from its place")
    assert "no more than 20 mm are possible while dbar holds" in left.sentence
