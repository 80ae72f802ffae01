"""Numbers that the guard derives where a scenario leaves them out."""

from __future__ import annotations

from dataclasses import replace

import pytest

from wmr_ctrl.control.setup import settle
from wmr_ctrl.guard.bounds import early_speed
from wmr_ctrl.scenario import load_scenario

ON = {"guard.enabled": True}


def derived(**changed: object):
    return settle(load_scenario("paper-simulation", {**ON, **changed}), None).guard


def test_dbar_counts_the_model_s_share_on_each_axis() -> None:
    alone, more = derived(), derived(**{"guard.d_model": [7.0, 3.0]})

    assert more.dbar == pytest.approx((alone.dbar[0] + 7.0, alone.dbar[1] + 3.0))


def test_friction_above_the_push_makes_nothing_faster_before_the_first_command() -> None:
    guard = derived(**{"guard.dbar": [60.0, 15.0], "actuator.delay": 0.02})
    held = replace(guard, f_min=(80.0, 5.0))

    assert early_speed(held) == (0.0, pytest.approx(0.02 * 10.0 / guard.M_min[1]))
