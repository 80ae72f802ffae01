"""The model against the mathematics that defines it."""

from __future__ import annotations

import math
import re

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.core.signals import PLANT_STATE, PSI
from wmr_ctrl.world.model.dynamics import (
    force_to_wheel,
    plant,
    reduced_mass,
    rk4_step,
    wheel_to_force,
)
from wmr_ctrl.world.model.kinematics import (
    error_rate,
    error_rotation,
    pose_rate,
    tracking_error,
)
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.paper_functions import constraint, projected, velocity_map

ANGLES = np.linspace(-7.0, 7.0, 29)
SCENARIO = load_scenario("paper-simulation-nominal")


def value(expression: ca.SX, symbols: list[ca.SX], *numbers: object) -> np.ndarray:
    return ca.Function("value", symbols, [expression])(*numbers).full()


def test_the_robot_never_moves_sideways() -> None:
    """H' A = 0: every velocity that H allows satisfies the constraint (3)."""
    theta = ca.SX.sym("theta")
    product = velocity_map(theta).T @ constraint(theta)

    assert max(abs(value(product, [theta], angle)).max() for angle in ANGLES) < 1e-15


def test_pose_rate_is_h_times_v() -> None:
    theta, v = ca.SX.sym("theta"), ca.SX.sym("v", 2)
    gap = pose_rate(theta, v) - velocity_map(theta) @ v

    assert all(not value(gap, [theta, v], angle, (0.3, -1.1)).any() for angle in ANGLES)


def test_projection_gives_the_reduced_dynamics() -> None:
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


def test_wheel_torques_and_forces_are_inverse() -> None:
    force = ca.SX.sym("force", 2)
    r, half_track = ca.SX(0.1), ca.SX(0.25)
    there_and_back = wheel_to_force(r, half_track, force_to_wheel(r, half_track, force))

    assert value(there_and_back, [force], (37.0, -2.5)).ravel() == pytest.approx(
        [37.0, -2.5], rel=1e-15
    )


def test_tracking_error_is_the_rotation_of_the_difference() -> None:
    pose_d, pose = ca.SX.sym("pose_d", 3), ca.SX.sym("pose", 3)
    gap = tracking_error(pose_d, pose) - error_rotation(pose[2]) @ (pose_d - pose)

    assert abs(value(gap, [pose_d, pose], (1, 2, 3), (-0.5, 0.4, 0.9))).max() < 1e-15


def test_error_rate_follows_from_both_kinematics() -> None:
    """Eqs. (33)-(35) are the derivative of Eq. (8) along q' = H v, q_d' = H_d v_d."""
    pose_d, pose, v_d, v = (ca.SX.sym(n, k) for n, k in (("qd", 3), ("q", 3), ("vd", 2), ("v", 2)))
    e = tracking_error(pose_d, pose)
    moving = ca.jtimes(
        e, ca.vertcat(pose_d, pose), ca.vertcat(pose_rate(pose_d[2], v_d), pose_rate(pose[2], v))
    )
    gap = moving - error_rate(e, v, v_d)
    for angle in ANGLES:
        assert (
            abs(
                value(
                    gap,
                    [pose_d, pose, v_d, v],
                    (1, 2, angle),
                    (-1, 0.5, 0.3),
                    (0.2, 0.1),
                    (0.7, -1),
                )
            ).max()
            < 1e-14
        )


def test_power_balance() -> None:
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


def test_runge_kutta_step_is_of_fourth_order() -> None:
    """Halving the step divides the error by 16."""
    system, h = plant(SCENARIO), ca.SX.sym("h")
    step = ca.Function("step", [system.u, system.x, system.p, h], [rk4_step(system, h)])

    def end(count: int) -> np.ndarray:
        state = ca.DM([0, 0, 0.3, 0.5, 0.4])
        for _ in range(count):
            state = step((20, 20.3, 0, 0, 0, 0), state, system.p0, 0.4 / count)
        return state.full().ravel()

    exact = end(2048)
    first, second = (abs(end(count) - exact).max() for count in (32, 64))

    assert first / second == pytest.approx(16, rel=0.2)


def test_orientation_and_heading_are_what_their_meanings_say():
    """As a formula that a reader types: both name the way in which the graph drives."""
    theta = 0.3
    known = {"theta": theta, "pi": math.pi}
    forward = PLANT_STATE[2].meaning.split("forward = ")[1]
    sines = {"sin": math.sin, "cos": math.cos, **known}
    named = eval(re.sub(r"(sin|cos) theta", r"\1(theta)", forward), sines)
    psi = eval(PSI.meaning.split("psi = ")[1], known)
    driven = np.asarray(ca.evalf(pose_rate(ca.SX(theta), ca.SX([1.0, 0.0])))).ravel()

    assert named == pytest.approx(driven[:2])
    assert (math.cos(psi), math.sin(psi)) == pytest.approx(driven[:2])
