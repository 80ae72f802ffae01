"""Test vectors of a law: samples in a row with what CasADi's virtual machine makes of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.model.system import System

Floats = NDArray[np.float64]

STEPS = 48
"""Samples; the memory is carried from each to the next."""

TOLERANCES = {False: 1e-12, True: 2e-3}
"""By whether it is single precision: largest error of a torque, relative to 1 N m + its size."""


@dataclass(frozen=True)
class Vectors:
    """Inputs (steps, inputs) and torques [N m] (steps, 2)."""

    inputs: Floats
    torques: Floats


def vectors_of(system: System, *, float32: bool = False) -> Vectors:
    """Samples around a trajectory, at rest, far away, near the limits, both signs.

    In single precision inputs and parameters are rounded to it first; the torques are those of
    double precision.
    """
    machine = system.function("step", [system.update, system.y])
    inputs, p, x = _inputs(), np.array(system.p0), np.array(system.x0)
    if float32:
        inputs, p = _rounded(inputs), _rounded(p)
    torques = np.empty((len(inputs), 2))
    for k, u in enumerate(inputs):
        following, torque = machine(u, x, p)
        x, torques[k] = following.full().ravel(), torque.full().ravel()
    return Vectors(inputs, torques)


def _inputs() -> Floats:
    draw = np.random.default_rng(2024)
    rows = []
    for k in range(STEPS):
        desired = [*draw.normal(size=2), draw.uniform(-3, 3), 0.2, 0.1, 0.0, 0.0]
        spread = (0.01, 0.1, 1.0, 6.0)[k % 4]
        error = draw.normal(size=3) * [spread, spread, min(spread, 1.0)]
        speed = draw.uniform(-0.95, 0.95, 2) * [1.0, 1.5] if k % 3 else np.zeros(2)
        rows.append([*desired, *(np.array(desired[:3]) - error), *speed])
    rounded: Floats = np.round(np.array(rows, dtype=float), 6)
    return rounded


def _rounded(values: Floats) -> Floats:
    single: Floats = values.astype(np.float32).astype(np.float64)
    return single
