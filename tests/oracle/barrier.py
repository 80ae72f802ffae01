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
    """``v`` held within plus and minus ``limit``."""
    return min(max(v, -limit), limit)


def barrier(v, c, u1, u2):
    """Barrier terms at speed ``v``, |v| < u1, for the auxiliary velocity ``c`` = v_c0."""
    mirrored = c < 0.0
    result = _barrier_right(-v if mirrored else v, abs(c), u1, u2)
    return _mirror(result) if mirrored else result


def _mirror(b):
    return BarrierTerms(-b.v_c1, -b.gap, b.V1, -b.V1_by_A, b.q)


def _barrier_right(v, c, u1, u2):
    if c <= u2:
        return _region1(v, c, u1, u2)
    excess = _excess(c, u1, u2)
    if excess <= 0.0:
        return _region2_above(v, -excess, u1, u2) if v > u2 else _region2_below(v, c, u1, u2)
    d = _distance(c - u1)
    if v > u2:
        return _region3_above(v, d, u1)
    # v_c1 - u2 = delta - d, with d (d + t) = 1 taken out of the difference
    return _region3_below(v, d, excess / (1.0 + 1.0 / (d * (u1 - u2))), u1, u2)


def _excess(c, u1, u2):
    """c - (u2 + 1/delta): positive in R3 only; near its zero evaluated in rationals."""
    delta = u1 - u2
    excess = (delta * (c - u2) - 1.0) / delta
    if abs(delta * (c - u2) - 1.0) < _NEAR:
        exact_u2 = Fraction(u2)
        excess = float(Fraction(c) - exact_u2 - 1 / (Fraction(u1) - exact_u2))
    return excess


def _distance(t):
    """d = u1 - v_c1 in R3, positive root of d (d + t) = 1."""
    root = math.hypot(t, 2.0)
    return 2.0 / (t + root) if t >= 0.0 else (root - t) / 2.0


def _f(v, u1, u2):
    """Eq. (15): -ln((u1 - |v|)/delta) beyond u2, else 0."""
    if abs(v) <= u2:
        return 0.0
    y = (abs(v) - u2) / (u1 - u2)
    return -math.log1p(-y) if y < 0.5 else -math.log((u1 - abs(v)) / (u1 - u2))


def _slope(v, u1, u2):
    """h(v)/(u1 - |v|), the barrier's share of Eq. (10) without its sign."""
    return 1.0 / (u1 - abs(v)) if abs(v) > u2 else 0.0


def _psi(y, rest):
    """(-ln(1 - y) - y)/y^2 for y < 1, given ``rest`` = 1 - y with all its digits."""
    if abs(y) < 0.05:
        return sum(y**n / (n + 2) for n in range(15))
    log = math.log1p(-y) if y < 0.5 else math.log(rest)
    return (-log - y) / (y * y)


def _region1(v, c, u1, u2):
    w = v - c
    if abs(v) <= u2:
        return BarrierTerms(c, w, 0.5 * w * w, 0.5 * w, 1.0)
    V1 = 0.5 * w * w + _f(v, u1, u2)
    A = w + math.copysign(_slope(v, u1, u2), v)
    return BarrierTerms(c, w, V1, V1 / A, w / A)


def _region2_below(v, c, u1, u2):
    n, a = u2 - v, c - u2
    V1 = 0.5 * n * n + a * n + _f(v, u1, u2)
    A = n + a + _slope(v, u1, u2)
    return BarrierTerms(u2, -n, V1, -V1 / A, n / A)


def _region2_above(v, b, u1, u2):
    """``b`` = u2 + 1/delta - c, the slope of V1 just above u2."""
    delta, w, rest = u1 - u2, v - u2, u1 - v
    psi = _psi(w / delta, rest / delta)
    A = b + w * (1.0 + 1.0 / (delta * rest))
    V1 = w * (b + w * (0.5 + psi / (delta * delta)))
    return BarrierTerms(u2, w, V1, V1 / A, w / A)


def _region3_above(v, d, u1):
    rest = u1 - v
    w = d - rest
    half = 0.5 + _psi(w / d, rest / d) / (d * d)
    slope = 1.0 + 1.0 / (d * rest)
    return BarrierTerms(u1 - d, w, w * w * half, w * half / slope, 1.0 / slope)


def _region3_below(v, d, p, u1, u2):
    """``p`` = v_c1 - u2."""
    m = u2 - v
    n, y = p + m, -p / d
    V1 = 0.5 * n * n + m / d + y * y * _psi(y, 1.0 - y) + _f(v, u1, u2)
    A = n + 1.0 / d + _slope(v, u1, u2)
    return BarrierTerms(u1 - d, -n, V1, -V1 / A, n / A)
