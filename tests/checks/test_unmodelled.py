"""Friction that a law neither knows nor learns leaves the robot behind: told, and so it drives."""

import re

import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import load_scenario

SOFT = {"gains.pid.Kp": [100.0, 4.0], "gains.kinematics.k": [4.0, 5.0, 4.0]}


def told(law, **changes):
    scenario = load_scenario("paper-simulation-nominal", changes)
    return [str(item) for item in warnings_for(settle(scenario, law)) if "no term" in str(item)]


@pytest.mark.slow
def test_it_is_as_far_behind_as_told():
    (text,) = told("pid", **SOFT)
    behind = float(re.findall(r"lag about ([\d.]+) m", text)[0])
    run = simulate("paper-simulation-nominal", "pid", overrides=SOFT)

    assert "Friction is 39.2 N from the start" in text
    assert "together by a factor of 2" in text
    assert run["e"][-2000:, 0].mean() == pytest.approx(behind, rel=0.06)
