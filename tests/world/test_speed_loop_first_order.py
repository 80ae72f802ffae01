"""The first-order speed loop."""

from __future__ import annotations

import math

import pytest

from tests.world.motion import based
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.speed_loop_first_order import FIRST_ORDER, reach


def test_it_pulls_as_far_as_a_first_order_goes_in_a_step_and_holds_friction() -> None:
    system = FIRST_ORDER.build(based(tau=[0.2, 0.1], gain=[1.1, 0.9]))
    torque = system.function("torque", [system.y])([0.5, 1.0, 0.3, -0.2], [0.0, 0.0], system.p0)
    right, left = torque.full().ravel()

    s = [0.001 / (1 - math.exp(-0.001 / tau)) for tau in (0.2, 0.1)]
    thrust = 50.0 * (1.1 * 0.5 - 0.3) / s[0] + 0.08 * 50.0 * 9.81
    assert (right + left) / 0.1 == pytest.approx(thrust, rel=1e-12)
    assert 0.25 * (right - left) / 0.1 == pytest.approx(5.4 * (0.9 + 0.2) / s[1], rel=1e-12)
    assert float(reach(0.001, 0.2)) == pytest.approx(s[0], rel=1e-12)


def test_a_limit_of_torque_makes_it_slower_than_a_governor_knows() -> None:
    assert FIRST_ORDER.bounded(based()).hidden == ""
    limited = override(based(), {"actuator.tau_max": 5.0})
    assert "actuator.tau_max" in FIRST_ORDER.bounded(limited).hidden
