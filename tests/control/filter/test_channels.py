"""Bounds of a wheel's rim follow from those of both axes, with half a track as the arm."""

import casadi as ca
import numpy as np
import pytest

from tests.tables import changes
from wmr_ctrl.control.filter.channels import channels_of
from wmr_ctrl.world.model.system import Parameters
from wmr_ctrl.world.scenario import load_scenario


def test_a_rim_has_the_pushes_of_both_axes_and_the_widest_of_their_gains():
    stated = changes("""
        robot.l = 0.2
        limits.v_u1 = [1.0, 2.0]
        filter.kind = clip
        filter.gain = [0.9, 1.1]
        filter.d = [0.05, 0.05]
        filter.channels = wheels
    """)
    scenario = load_scenario("paper-simulation", stated)
    p = Parameters(scenario)
    numbers = ca.SX([0.9, 0.8]), ca.SX([1.1, 1.3]), ca.SX([0.05, 0.1])
    right, left = channels_of(scenario, p, numbers)
    b = right.bounds
    rows = (side.of(unit) for side in (right, left) for unit in ((1, 0), (0, 1)))
    rim = ca.vertcat(b.V, b.dbar, b.nbar, b.K_min, b.K_max, *rows)
    given = np.concatenate([port.value for port in p.ports])
    found = ca.Function("rim", [ca.vertcat(*(port.sym for port in p.ports))], [rim])(given)

    assert found.full().ravel() == pytest.approx(
        [0.4, 0.05 + 0.2 * 0.1, 0.0, 0.8, 1.3, 1.0, 0.2, 1.0, -0.2], abs=1e-6
    )
    assert right.largest == left.largest == pytest.approx((0.4, 0.4))
