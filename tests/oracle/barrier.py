"""Barrier function of one axis, Eqs. (10)-(20), in forms that do not cancel.

Written for c = v_c0 >= 0 (a negative c mirrors the axis), with delta = u1 - u2, there are three
regions, and x = v_c1 is the minimiser of V1 over v:

    R1  c <= u2                    x = c
    R2  u2 < c <= u2 + 1/delta     x = u2
    R3  u2 + 1/delta < c           x = u1 - d,  d = 2/(t + sqrt(t^2 + 4)),  t = c - u1

In each region V1, A = dV1/dv and the gap w = v - x are sums of terms of one sign, so V1/A and
q = w/A keep their digits where the printed differences lose all of them, and have their limits
at v = x without a special case.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

_NEAR = 1e-9  # distance from the border of R2 and R3 below which the side is decided exactly


@dataclass(frozen=True, slots=True)
class BarrierTerms:
    """Values of one axis; speeds in the axis' unit (m/s or rad/s)."""

    v_c1: float
    """Minimiser, Eq. (18)."""
    gap: float
    """v - v_c1."""
    V1: float
    """Barrier Lyapunov function, Eq. (20)."""
    V1_by_A: float
    """V1/A, with A of Eq. (10); 0 at v = v_c1."""
    q: float
    """(v - v_c1)/A, in [0, 1]."""


def clip(v, limit):
    """``v`` limited to [-limit, limit]."""
    return min(max(v, -limit), limit)


def barrier(v, c, u1, u2):
    """Barrier terms at speed ``v``, |v| < u1, for the auxiliary velocity ``c`` = v_c0."""
    return mirrored(_barrier_right, v, c, u1, u2)


def mirrored(right, v, c, u1, u2):
    """Terms for any sign of ``c``, by the function for c >= 0."""
    if c >= 0.0:
        return right(v, c, u1, u2)
    b = right(-v, -c, u1, u2)
    return BarrierTerms(-b.v_c1, -b.gap, b.V1, -b.V1_by_A, b.q)


def _barrier_right(v, c, u1, u2):
    f, slope = _f(v, u1, u2), 1.0 / (u1 - abs(v)) if abs(v) > u2 else 0.0
    if c <= u2:
        return region1(v, c, f, slope)
    excess = _excess(c, u1, u2)
    if excess > 0.0:
        d = distance(c - u1)
        # v_c1 - u2 = delta - d, with d (d + t) = 1 taken out of the difference
        p = excess / (1.0 + 1.0 / (d * (u1 - u2)))
        return region3(v, d, p, 1.0 / d, f, slope, u1, u2)
    if v > u2:
        return _region2_above(v, -excess, u1, u2)
    n, a = u2 - v, c - u2
    A, V1 = n + a + slope, 0.5 * n * n + a * n + f
    return BarrierTerms(u2, -n, V1, -V1 / A, n / A)


def _excess(c, u1, u2):
    """c - (u2 + 1/delta): positive in R3 only; near its zero evaluated in rationals."""
    delta = u1 - u2
    excess = (delta * (c - u2) - 1.0) / delta
    if abs(delta * (c - u2) - 1.0) < _NEAR:
        exact_u2 = Fraction(u2)
        excess = float(Fraction(c) - exact_u2 - 1 / (Fraction(u1) - exact_u2))
    return excess


def distance(t, k=1.0):
    """Positive root of d (d + t) = k; d = u1 - v_c1 in R3 for t = c - u1."""
    root = math.hypot(t, 2.0 * math.sqrt(k))
    return 2.0 * k / (t + root) if t >= 0.0 else (root - t) / 2.0


def _f(v, u1, u2):
    """Eq. (15): -ln((u1 - |v|)/delta) beyond u2, else 0."""
    if abs(v) <= u2:
        return 0.0
    y = (abs(v) - u2) / (u1 - u2)
    return -math.log1p(-y) if y < 0.5 else -math.log((u1 - abs(v)) / (u1 - u2))


def psi(y, rest):
    """(-ln(1 - y) - y)/y^2 for y < 1, given ``rest`` = 1 - y with all its digits."""
    if abs(y) < 0.05:
        return sum(y**n / (n + 2) for n in range(15))
    log = math.log1p(-y) if y < 0.5 else math.log(rest)
    return (-log - y) / (y * y)


def region1(v, c, f, slope):
    """Terms where v_c1 = ``c``; ``f`` and ``slope`` of the barrier at ``v``."""
    w = v - c
    if slope == 0.0:
        return BarrierTerms(c, w, 0.5 * w * w, 0.5 * w, 1.0)
    V1, A = 0.5 * w * w + f, w + math.copysign(slope, v)
    return BarrierTerms(c, w, V1, V1 / A, w / A)


def _region2_above(v, b, u1, u2):
    """``b`` = u2 + 1/delta - c, the slope of V1 just above u2."""
    delta, w, rest = u1 - u2, v - u2, u1 - v
    A = b + w * (1.0 + 1.0 / (delta * rest))
    V1 = w * (b + w * (0.5 + psi(w / delta, rest / delta) / (delta * delta)))
    return BarrierTerms(u2, w, V1, V1 / A, w / A)


def region3(v, d, p, a, f, slope, u1, u2):
    """Terms where v_c1 is ``p`` above u2, ``d`` below u1, and the slope there is ``a``."""
    if v > u2:
        rest = u1 - v
        w = d - rest
        half = 0.5 + psi(w / d, rest / d) / (d * d)
        steep = 1.0 + 1.0 / (d * rest)
        return BarrierTerms(u1 - d, w, w * w * half, w * half / steep, 1.0 / steep)
    m = u2 - v
    n, y = p + m, -p / d
    V1, A = 0.5 * n * n + m * a + y * y * psi(y, 1.0 - y) + f, n + a + slope
    return BarrierTerms(u1 - d, -n, V1, -V1 / A, n / A)
