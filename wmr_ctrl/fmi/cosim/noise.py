"""The disturbance that the master draws: the native loop's numbers, to the bit.

The integers come from NumPy; logarithm, cosine and sine from the C library, which the compiled loop
uses too.
"""

from __future__ import annotations

import math

from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.oracle.noise import TORQUE, key_of, raw_blocks, uniforms

_ATTEMPTS = 64


def torque_noise(scenario: Scenario, seed: int) -> list[tuple[float, float]]:
    """Torques (right, left) [N m] of every control sample."""
    count, std = scenario.clock.samples, scenario.disturbance.std
    if std == 0.0:
        return [(0.0, 0.0)] * count
    key, bound = key_of(seed), scenario.disturbance.truncate
    pairs = uniforms(raw_blocks(key, 0, count, TORQUE))[:, :2].tolist()
    found = []
    for k, (first, second) in enumerate(pairs):
        normal, attempt = _normal(first, second), 0
        while max(map(abs, normal)) > bound and attempt + 1 < _ATTEMPTS:
            attempt += 1
            normal = _normal(*uniforms(raw_blocks(key, k, 1, TORQUE, attempt))[0, :2].tolist())
        found.append((std * _clipped(normal[0], bound), std * _clipped(normal[1], bound)))
    return found


def _normal(first: float, second: float) -> tuple[float, float]:
    radius, angle = math.sqrt(-2.0 * math.log(1.0 - first)), 2.0 * math.pi * second
    return radius * math.cos(angle), radius * math.sin(angle)


def _clipped(value: float, bound: float) -> float:
    return max(-bound, min(bound, value))
