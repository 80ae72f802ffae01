"""Dynamics against the mathematics that defines them."""

import casadi as ca
import numpy as np
import pytest

from tests.world.model.test_kinematics import ANGLES, value
from wmr_ctrl.world.model.dynamics import (
    plant,
    reduced_mass,
    rk4_step,
    wheel_to_force,
)
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.paper_functions import projected

SCENARIO = load_scenario("paper-simulation-nominal")


def test_projection_gives_the_reduced_dynamics():
    """Eq. (4): H' M H = diag(m, I), H' B tau = B1 tau, whatever the heading."""
    theta, tau = ca.SX.sym("theta"), ca.SX.sym("tau", 2)
    numbers = tuple(ca.SX(number) for number in (50.0, 5.4, 0.1, 0.25))
    mass, input_map = projected(theta, *numbers)
    for angle in ANGLES:
        assert value(mass, [theta], angle) == pytest.approx(np.diag([50.0, 5.4]), abs=1e-13)
        force = value(input_map @ tau, [theta, tau], angle, (3.0, -1.0))
        assert force == pytest.approx(
            value(wheel_to_force(*numbers[2:], tau), [tau], (3.0, -1.0)), abs=1e-13
        )
    assert ca.evalf(reduced_mass(*numbers[:2])).full().ravel() == pytest.approx([50.0, 5.4])


def test_power_balance():
    """The kinetic energy's rate is the power of wheels and pushes less that of friction."""
    system = plant(SCENARIO)
    x, u = system.x, system.u
    energy = 0.5 * (50.0 * x[3] ** 2 + 5.4 * x[4] ** 2)
    wheel_speeds = ca.vertcat(x[3] + 0.25 * x[4], x[3] - 0.25 * x[4]) / 0.1
    friction = 0.08 * 50.0 * 9.81 * ca.tanh(x[3] / 0.01) * x[3]
    power = ca.dot(u[0:2] + u[2:4], wheel_speeds) + ca.dot(u[4:6], x[3:5])
    gap = ca.jtimes(energy, x, system.update) - power + friction
    inputs = (3, -1, 0.2, 0.1, 7, -0.4)
    for speed in (-0.9, -0.003, 0.0, 0.4):
        found = value(gap, [u, x, system.p], inputs, (0, 0, 1, speed, 0.8), system.p0)
        assert abs(found).max() < 1e-12


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
