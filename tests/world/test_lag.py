"""The lag of the drives, and time constants that vary."""

import math

import pytest

from tests.world.motion import scenario
from wmr_ctrl.world.lag import LAG, equivalent_lag, stepped


@pytest.mark.parametrize("drawn", [-1.0, 0.0, 0.5])
def test_the_torque_nears_its_command_by_the_time_constant_of_the_sample(drawn):
    system = LAG.build(scenario({"actuator.lag": 0.02, "actuator.lag_spread": 0.5}))
    step = system.function("step", [system.y, system.update])

    acting, after = step([3.0, -1.0], [1.0, 1.0], system.p0, [drawn, 0.0])

    left = math.exp(-0.001 / (0.02 * (1 + 0.5 * drawn)))
    assert acting.full().ravel() == pytest.approx([3 - 2 * left, -1 + 2 * left], rel=1e-14)
    assert (after == acting).full().all()


@pytest.mark.parametrize("lag", [0.004, 0.02, 3.0])
def test_a_held_lag_is_faster_by_half_a_step_and_none_is_left_of_a_short_one(lag):
    assert stepped(lag, 0.001) == pytest.approx(lag - 0.0005, abs=3e-5)
    assert stepped(lag, 0.001) == equivalent_lag(0.001, math.expm1(0.001 / lag))
    assert stepped(1e-6, 0.001) == stepped(0.0, 0.001) == 0.0


def test_the_guard_is_told_the_range_of_time_constants():
    least, most = LAG.bounded(scenario({"actuator.lag": 0.02, "actuator.lag_spread": 0.5})).lag

    assert least == pytest.approx(stepped(0.01, 0.001), rel=1e-9)
    assert least < stepped(0.01, 0.001)
    assert most == pytest.approx(0.03)
    assert LAG.bounded(scenario({"actuator.lag": 0.02})).lag == (0.02, 0.02)
