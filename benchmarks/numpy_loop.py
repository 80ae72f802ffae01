"""The closed loop as a plain Python loop over NumPy steps, to hold the hand-written C against."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .layout import noise_key
from .numpy_step import NumpyLaws
from .setup import Case, Setup

Array = NDArray[np.float64]


def closed_loop(law: str, setup: Setup, case: Case) -> tuple[Array, Array, int]:
    """Run ``mb`` or ``nn``; return final state (5,), max |v| (2,), number of steps in violation."""
    laws, key, W = NumpyLaws(setup), noise_key(case.seed), np.zeros((2, 64))
    state = np.array(case.initial)
    velocities = [state[3:]]
    for k in range(case.samples):
        reference = circle(case, k * case.control)
        if law == "mb":
            torque = laws.mb_step(reference, state[:3], state[3:])
        else:
            torque, W = laws.nn_step(reference, state[:3], state[3:], W)
        torque = torque + case.noise_std * torque_noise(key, k)
        for step in range(k * case.substeps, (k + 1) * case.substeps):
            robot = case.later if step * case.plant >= case.t_change - 1e-9 else case.first
            state = rk4(setup, robot, torque, state, case.plant)
            velocities.append(state[3:])
    speeds = np.abs(np.array(velocities))
    beyond = np.any(speeds > np.array(setup.v_u1), axis=1)
    return state, speeds.max(axis=0), int(beyond.sum())


def circle(case: Case, t: float) -> Array:
    """Return the reference (7,) at time ``t`` [s]."""
    R, rate = case.radius, case.rate
    x, y = R * np.sin(rate * t), R - R * np.cos(rate * t)
    return np.array([x, y, rate * t - np.pi / 2, R * rate, rate, 0.0, 0.0])


def torque_noise(key: NDArray[np.uint64], k: int) -> Array:
    """Return two standard normal numbers (right, left) of control step ``k``."""
    counter = (k - 1) % 2**256  # NumPy counts up before it draws
    raw = np.random.Philox(key=key, counter=counter).random_raw(4)
    u0, u1 = (raw[:2] >> np.uint64(11)) * 2.0**-53
    radius, angle = np.sqrt(-2 * np.log(1 - u0)), 2 * np.pi * u1
    return np.array([radius * np.cos(angle), radius * np.sin(angle)])


def rk4(
    setup: Setup, robot: tuple[float, float, float], torque: Array, state: Array, h: float
) -> Array:
    """Return the state (5,) after one Runge-Kutta step of ``h`` [s] with the torque held."""
    k1 = rate(setup, robot, torque, state)
    k2 = rate(setup, robot, torque, state + h / 2 * k1)
    k3 = rate(setup, robot, torque, state + h / 2 * k2)
    k4 = rate(setup, robot, torque, state + h * k3)
    return state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def rate(setup: Setup, robot: tuple[float, float, float], torque: Array, state: Array) -> Array:
    """Return the state's rate (5,) by (1)-(6) with Coulomb friction smoothed by tanh."""
    m, inertia, mu = robot
    _, _, theta, v1, omega = state
    force, moment = (torque[0] + torque[1]) / setup.r, setup.l * (torque[0] - torque[1]) / setup.r
    friction = mu * m * setup.g * np.tanh(v1 / setup.v_s)
    turn = [-v1 * np.sin(theta), v1 * np.cos(theta), omega]
    return np.array([*turn, (force - friction) / m, moment / inertia])
