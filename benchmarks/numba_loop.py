"""Loops in numba around `numba_step`: steps for timing, and the network law's closed loop."""

# ruff: noqa: ANN001, ANN201 - numba finds the types
from __future__ import annotations

from math import cos, pi, sin, tanh

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .layout import noise_key
from .numba_step import NODES, law_of, nn_step
from .setup import Case, Setup

Array = NDArray[np.float64]


@njit
def repeat(law, steps, rows, W, S):
    """Sum of the torques of ``steps`` steps over a ring of rows."""
    total, place = 0.0, 0
    for _ in range(steps):
        right, left = nn_step(law, rows[place], W, S)
        total += right + left
        place = 0 if place + 1 == len(rows) else place + 1
    return total


def closed_loop(setup: Setup, case: Case) -> tuple[Array, Array]:
    """Final state (5,) and weights (2, 64) of a run of the network law."""
    state, W, change = np.array(case.initial), np.zeros((2, NODES)), case.t_change / case.plant
    robots = tuple((m, inertia, mu * setup.g) for m, inertia, mu in (case.first, case.later))
    wheels, first = (setup.r, setup.l, setup.v_s), min(np.ceil(change - 1e-6), 2.0**62)
    clock = (case.control, case.plant, case.substeps, int(first))
    run(law_of(setup), wheels, robots, (case.radius, case.rate), clock, noise(case), state, W)
    return state, W


def noise(case: Case) -> Array:
    """Torque noise (samples, 2) [N m]: Philox blocks in a row, two normal numbers of each."""
    bits = np.random.Philox(key=noise_key(case.seed), counter=2**256 - 1)
    raw = bits.random_raw(4 * case.samples).reshape(-1, 4)
    u0, u1 = (raw[:, :2] >> np.uint64(11)).T * 2.0**-53
    radius = case.noise_std * np.sqrt(-2 * np.log(1 - u0))
    return np.column_stack([radius * np.cos(2 * np.pi * u1), radius * np.sin(2 * np.pi * u1)])


@njit
def run(law, wheels, robots, circle, clock, noise, state, W):
    """Run the loop to its end; ``state`` and ``W`` are changed in place."""
    (control, plant, substeps, change), (r, half_track, v_s) = clock, wheels
    S, row = np.empty(NODES), np.zeros(12)
    for k in range(len(noise)):
        desired(circle, k * control, row)
        row[7:] = state
        right, left = nn_step(law, row, W, S)
        right, left = right + noise[k, 0], left + noise[k, 1]
        force, moment = (right + left) / r, half_track * (right - left) / r
        for i in range(k * substeps, (k + 1) * substeps):
            rk4(robots[1] if i >= change else robots[0], v_s, force, moment, plant, state)


@njit
def desired(circle, t, row):
    """Reference at time t [s]."""
    radius, rate = circle
    row[0], row[1] = radius * sin(rate * t), radius - radius * cos(rate * t)
    row[2], row[3], row[4] = rate * t - 0.5 * pi, radius * rate, rate


@njit
def rk4(robot, v_s, force, moment, h, state):
    """One Runge-Kutta step of h [s], force [N] and moment [N m] held."""
    m, inertia, drag = robot
    half, push, turn = 0.5 * h, force / m, moment / inertia
    theta, v1, omega1 = state[2], state[3], state[4]
    omega2, omega4 = omega1 + half * turn, omega1 + h * turn
    a1 = push - drag * tanh(v1 / v_s)
    v2 = v1 + half * a1
    a2 = push - drag * tanh(v2 / v_s)
    v3 = v1 + half * a2
    a3 = push - drag * tanh(v3 / v_s)
    v4 = v1 + h * a3
    a4 = push - drag * tanh(v4 / v_s)
    theta2, theta3, theta4 = theta + half * omega1, theta + half * omega2, theta + h * omega2
    aside = v1 * sin(theta) + 2 * (v2 * sin(theta2) + v3 * sin(theta3)) + v4 * sin(theta4)
    along = v1 * cos(theta) + 2 * (v2 * cos(theta2) + v3 * cos(theta3)) + v4 * cos(theta4)
    state[0] -= h / 6 * aside
    state[1] += h / 6 * along
    state[2] += h / 6 * (omega1 + 4 * omega2 + omega4)
    state[3] += h / 6 * (a1 + 2 * (a2 + a3) + a4)
    state[4] = omega4
