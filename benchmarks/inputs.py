"""Rings of inputs for timing loops and random admissible inputs for checks, as rows of hand.h."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .setup import Case, Setup

Array = NDArray[np.float64]


def tracking_rows(count: int = 256, case: Case | None = None) -> Array:
    """Rows (count, 12) around the circle: slowly varying, errors of centimetres, no saturation.

    What a controller sees for nearly all of a run.  One turn of the ring is smooth and periodic.
    """
    case = case or Case()
    turn = 2 * np.pi * np.arange(count) / count
    R, speed = case.radius, case.radius * case.rate
    flat = np.zeros(count)
    x_d, y_d = R * np.sin(turn), R - R * np.cos(turn)
    x, y = x_d + 0.02 * np.sin(3 * turn), y_d + 0.02 * np.cos(2 * turn)
    theta = turn - np.pi / 2 + 0.03 * np.sin(5 * turn)
    v1, omega = speed + 0.05 * np.sin(4 * turn), case.rate + 0.1 * np.cos(7 * turn)
    desired = [x_d, y_d, turn - np.pi / 2, flat + speed, flat + case.rate, flat, flat]
    return np.column_stack([*desired, x, y, theta, v1, omega])


def mixed_rows(count: int = 256, seed: int = 0, setup: Setup | None = None) -> Array:
    """Random admissible rows (count, 12): |v_c0| in all three regions, both signs, |v| < v_u1.

    The pose error is chosen backwards from the wanted v_c0 (7); one row in ten has a velocity
    within a per mille of v_u1.
    """
    setup, rng = setup or Setup(), np.random.default_rng(seed)
    desired = _random_reference(rng, count)
    e = _errors_for(_wanted(rng, count, setup), desired, setup, rng)
    theta = desired[:, 2] - e[:, 2]
    s, c = np.sin(theta), np.cos(theta)
    x = desired[:, 0] + s * e[:, 0] + c * e[:, 1]
    y = desired[:, 1] - c * e[:, 0] + s * e[:, 1]
    v = _velocities(rng, count, setup)
    return np.column_stack([desired, x, y, theta, v])


def plant_torques(setup: Setup, h: float, count: int = 256) -> Array:
    """Wheel torques (count, 2) [N m] under which v1 swings between 0.1 and 0.2 m/s for ever.

    Friction is then always in the part of tanh that costs most, and nothing drifts away.
    """
    turn = 2 * np.pi * (np.arange(count) + 0.5) / count
    swing = 0.05
    v1, rate = 0.15 + swing * np.sin(turn), swing * np.cos(turn) * 2 * np.pi / (count * h)
    mean = 0.5 * setup.r * setup.m * (rate + setup.mu * setup.g * np.tanh(v1 / setup.v_s))
    half = 0.05 * np.cos(turn)
    return np.column_stack([mean + half, mean - half])


def _random_reference(rng: np.random.Generator, count: int) -> Array:
    pose = rng.uniform([-3, -3, -4], [3, 3, 4], (count, 3))
    rates = rng.uniform([0.05, -1, -0.5, -0.5], [0.75, 1, 0.5, 0.5], (count, 4))
    return np.column_stack([pose, rates])


def _wanted(rng: np.random.Generator, count: int, setup: Setup) -> Array:
    """v_c0 (count, 2), a third in each region, region 3 up to thirty times its edge."""
    u1, u2 = np.array(setup.v_u1), np.array(setup.v_u2)
    edge = u2 + 1 / (u1 - u2)
    region = rng.integers(0, 3, (count, 2))
    share = rng.uniform(0, 1, (count, 2))
    sizes: Array = np.choose(region, [u2 * share, u2 + (edge - u2) * share, edge * 30**share])
    signed: Array = sizes * rng.choice([-1.0, 1.0], (count, 2))
    return signed


def _errors_for(v_c0: Array, desired: Array, setup: Setup, rng: np.random.Generator) -> Array:
    k1, k2, k3 = setup.k
    v1_d, v2_d = desired[:, 3], desired[:, 4]
    e3 = rng.uniform(-3, 3, len(v_c0))
    e1 = (v_c0[:, 0] - v1_d * np.cos(e3)) / k1
    e2 = (v_c0[:, 1] - v2_d - k3 * np.sin(e3)) / (k2 * v1_d)
    return np.column_stack([e1, e2, e3])


def _velocities(rng: np.random.Generator, count: int, setup: Setup) -> Array:
    u1 = np.array(setup.v_u1)
    near = rng.uniform(0, 1, (count, 2)) < 0.1
    share = np.where(near, rng.uniform(0.999, 0.999999, (count, 2)), rng.uniform(0, 1, (count, 2)))
    v: Array = u1 * share * rng.choice([-1.0, 1.0], (count, 2))
    return v
