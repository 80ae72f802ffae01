"""Proximal map of the barrier, from its optimality condition c - x in k df(x)."""

from __future__ import annotations

import math


def nearest(c: float, k: float, u1: float, u2: float, smooth: bool = False) -> float:
    """The x that minimises (x - c)^2/2 + k f(x), |x| < u1 [m/s or rad/s]."""
    return math.copysign(_right(abs(c), k, u1, u2, smooth), c)


def _right(c: float, k: float, u1: float, u2: float, smooth: bool) -> float:
    if c <= u2:
        return c
    delta = u1 - u2
    if smooth:
        d = _root(c - u1 + k / delta, k)
        return u2 + (c - u2) / (1.0 + k / (d * delta))
    if c <= u2 + k / delta:
        return u2
    return u1 - _root(c - u1, k)


def _root(t: float, k: float) -> float:
    """d > 0 with d (d + t) = k."""
    r = math.hypot(t, 2.0 * math.sqrt(k))
    return 2.0 * k / (t + r) if t >= 0.0 else (r - t) / 2.0
