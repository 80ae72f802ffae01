"""The guard behind drives with a delay: commands in transit, refusals, and speeds reached."""

import math
from functools import partial

import casadi as ca
import pytest

from wmr_ctrl.control.guard.delay import in_flight
from wmr_ctrl.control.guard.guard import Bounds, ceiling, clipped, floor
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import load_scenario

ON = {"guard.enabled": True}


def test_commands_under_way_push_by_the_time_that_they_act():
    """Commands in transit push by the sum of tau_j max(+-F_j + net, 0)/M_min.

    A force that is NaN is replaced by a safe force.
    """
    row = {"u1": 1.0, "period": 0.01, "M_min": 45.0, "M_max": 70.0, "dbar": 60.0, "nbar": 0.0,
           "alpha": 100.0, "brake": 400.0,
           "f_min": 10.0, "f_speed": 0.0, "delay": 0.015}  # fmt: skip
    b = Bounds(**{name: ca.SX(value) for name, value in row.items()})
    coming = in_flight([(ca.SX([500.0, 0.0]), 1.0), (ca.SX([-200.0, 0.0]), 0.5)], 0, b)
    force, low, high, ahead, back = (
        float(ca.evalf(item))
        for item in (
            *(
                f(ca.SX(0.7), b, coming)
                for f in (partial(clipped, ca.SX(math.nan)), floor, ceiling)
            ),
            coming.ahead,
            coming.back,
        )
    )

    assert (ahead, back) == (pytest.approx(0.01 * 550 / 45), pytest.approx(0.005 * 250 / 45))
    assert low <= force <= high


def test_condition_is_the_necessary_one():
    """The guard accepts 2 dbar (T + delay) <= M_min v_u1 at the edge and refuses it beyond.

    This is the condition for alpha = 1/T.
    """
    edge = 45.0 / (2 * 0.05)
    for factor, possible in ((1 - 1e-9, True), (1 + 1e-9, False)):
        stated = {"guard.dbar": [factor * edge, 1.0], "guard.trust": True}
        changed = {**ON, **stated, "actuator.delay": 0.04}
        scenario = load_scenario("paper-simulation", changed)
        if possible:
            assert settle(scenario, None).guard.brake[0] >= edge * factor
        else:
            with pytest.raises(ScenarioError, match="axis 1"):
                settle(scenario, None)
