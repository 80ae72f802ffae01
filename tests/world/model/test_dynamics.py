"""Dynamics against their mathematical definitions."""

import math

import casadi as ca
import pytest

from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.scenario import load_scenario

SCENARIO = load_scenario("paper-simulation-nominal")


def test_rates_are_those_of_newton():
    """Wheels of 3.2 N m and -0.9 N m, a push, and the largest friction."""
    system = plant(SCENARIO)
    rate = system.function("rate", [system.update])
    found = rate((3, -1, 0.2, 0.1, 7, -0.4), (0, 0, 0.3, 0.4, 0.8), system.p0).full().ravel()

    thrust, moment = 2.3 / 0.1 + 7 - 0.08 * 50 * 9.81, 0.25 * 4.1 / 0.1 - 0.4
    way = [-0.4 * math.sin(0.3), 0.4 * math.cos(0.3), 0.8]
    assert found == pytest.approx([*way, thrust / 50, moment / 5.4])


def test_runge_kutta_step_is_of_fourth_order():
    """Halving the step divides the error by 16."""
    system, h = plant(SCENARIO), ca.SX.sym("h")
    step = ca.Function("step", [system.u, system.x, system.p, h], [rk4_step(system, h)])

    def end(count):
        state = ca.DM([0, 0, 0.3, 0.5, 0.4])
        for _ in range(count):
            state = step((20, 20.3, 0, 0, 0, 0), state, system.p0, 0.4 / count)
        return state.full().ravel()

    exact = end(2048)
    first, second = (abs(end(count) - exact).max() for count in (32, 64))

    assert first / second == pytest.approx(16, rel=0.2)
