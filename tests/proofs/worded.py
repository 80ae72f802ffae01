"""Samples for claims as they are worded: numbers at and between boundaries, and graphs as
numbers.
"""

import casadi as ca
import numpy as np

SAMPLES = 100_000
NEAR = 1e-9
"""Share of a claim's own size that doubles may miss it by."""

CHECKS = {}


def about(*ids):
    """Register a check for these entries."""

    def enter(check):
        for key in ids:
            CHECKS.setdefault(key, []).append(check)
        return check

    return enter


def share(rng):
    """Numbers from 0 to 1, a sixth of them at each end."""
    value = rng.uniform(size=SAMPLES)
    at = rng.integers(0, 6, SAMPLES)
    return np.where(at == 0, 0.0, np.where(at == 1, 1.0, value))


def signed(rng):
    """Numbers from -1 to 1."""
    return rng.uniform(-1, 1, SAMPLES)


def ways(rng):
    """Forwards or backwards, 1 or -1."""
    return rng.choice([-1.0, 1.0], SAMPLES)


def several(rng, count):
    """Return ``count`` columns of positive numbers."""
    return [positive(rng) for _ in range(count)]


def positive(rng):
    """Numbers above 0 of some orders of magnitude."""
    return np.exp(rng.normal(0.0, 1.2, SAMPLES))


def between(rng, low, high):
    """Numbers from low to high, including both ends."""
    part = share(rng)
    return np.clip(low + part * (high - low), low, high)


def around(rng, size):
    """Numbers of either sign, mostly up to ``size``, some far above."""
    far = np.where(rng.integers(0, 8, SAMPLES) == 0, 30.0, 1.3)
    return ways(rng) * share(rng) * size * far


def evaluated(symbols, outputs, numbers):
    """The scalar outputs for each sample of the scalar symbols."""
    graph = ca.Function("graph", [ca.vertcat(*symbols)], [ca.vertcat(*outputs)])
    rows = np.stack([np.broadcast_to(item, SAMPLES) for item in numbers])
    return list(np.array(graph(rows)))


def calculated(formula, *numbers):
    """A function of the product for each sample."""
    symbols = [ca.SX.sym(f"x{i}") for i in range(len(numbers))]
    return evaluated(symbols, [ca.SX(item) for item in formula(*symbols)], numbers)


def left(most, value, *sizes):
    """Return the margin ``most - value``, relative to the largest of all sizes."""
    size = np.maximum.reduce([np.abs(item) + 0 * most for item in (most, value, *sizes)])
    return (most - value) / np.maximum(size, 1e-300)


def same(one, other, *sizes):
    """Negative difference of both, relative to the largest of all sizes."""
    return -np.abs(left(one, other, *sizes))
