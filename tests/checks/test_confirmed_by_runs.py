"""Runs confirm the reports of checks on late poses, unmodelled friction and wrong masses."""

import re

import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import stability, warnings_for
from wmr_ctrl.theory.checks.stable_ranges import largest_stable_period
from wmr_ctrl.theory.checks.surroundings import lost_samples, rare_poses
from wmr_ctrl.world.scenario import load_scenario


@pytest.mark.slow
@pytest.mark.parametrize("age, stable", [(0.1, True), (0.2, False)])
def test_runs_cycle_where_a_pose_is_said_to_be_too_old(age, stable):
    scenario = load_scenario("paper-simulation-nominal", {"sensor.pose_delay": age})
    remarks = [item.key for item in simulate(scenario, "prox").remarks]

    assert (largest_stable_period(scenario, "prox") > 0.01) is stable
    assert ("oscillates" not in remarks) is stable


def test_what_is_left_out_is_said():
    rare = {"sensor.pose_period": 0.1, "sensor.pose_dropout": 0.3}

    assert rare_poses(load_scenario("paper-simulation")) == ""
    assert lost_samples(load_scenario("paper-simulation")) == ""
    assert lost_samples(load_scenario("paper-simulation", rare)) == (
        "as if nothing were lost, though 30% of the poses may be"
    )
    assert rare_poses(load_scenario("paper-simulation", rare)) == (
        "as if a pose came at every sample, though one comes every 0.1 s"
    )


SOFT = {"gains.pid.Kp": [100.0, 4.0], "gains.kinematics.k": [4.0, 5.0, 4.0]}


def without_a_term(law, **changes):
    scenario = load_scenario("paper-simulation-nominal", changes)
    return [str(item) for item in warnings_for(settle(scenario, law)) if "no term" in str(item)]


@pytest.mark.slow
def test_it_is_as_far_behind_as_told():
    (text,) = without_a_term("pid", **SOFT)
    behind = float(re.findall(r"lag about ([\d.]+) m", text)[0])
    run = simulate("paper-simulation-nominal", "pid", overrides=SOFT)

    assert "Friction is 39.2 N from the start" in text
    assert "together by a factor of 2" in text
    assert run["e"][-2000:, 0].mean() == pytest.approx(behind, rel=0.06)


def cycles(overrides, law):
    """Return whether a displacement of 0.1 mm grows on a floor without friction."""
    still = {"robot.mu": 0.0, "model.mu": 0.0, "initial.pose": [1e-4, 0.0, -1.5707],
             "initial.velocity": [0.2, 0.1], "clock.duration": 40.0}  # fmt: skip
    torque = simulate("paper-simulation-nominal", law, overrides=still | overrides)["tau_right"]
    return bool(abs(torque[-50:]).max() > abs(torque[:10]).max())


@pytest.mark.parametrize("law", ["prox", "kanayama"])
@pytest.mark.slow
def test_runs_cycle_just_outside_the_masses_that_are_said(law):
    period = {"clock.control": 0.1}
    low, high = stability(load_scenario("paper-simulation-nominal", period), law).masses
    for ratio, outside in ((0.9 * low, True), (1.1 * low, False), (0.9 * high, False)):
        robot = {"robot.m": 50.0 * ratio, "robot.I": 5.4 * ratio, "model.m": 50.0, "model.I": 5.4}
        assert cycles(period | robot, law) is outside
