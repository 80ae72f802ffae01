"""What is said of late drives and sensors: no figure contradicts another, and runs agree."""

import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.theory.checks import stability
from wmr_ctrl.world.scenario import load_scenario


def cycles(overrides, law):
    """Whether a displacement of a tenth of a millimetre grows, on a floor without friction."""
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
