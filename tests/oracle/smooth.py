"""Barrier function whose slope is continuous: f = -ln((u1 - |v|)/delta) - (|v| - u2)/delta.

For c = v_c0 >= 0 the minimiser is c up to u2 and u2 + p beyond, without a dead zone at u2.
"""

import math

from tests.oracle.barrier import BarrierTerms, _distance, _mirror, _psi, _region3_above


def smooth_barrier(v, c, u1, u2):
    """Barrier terms at speed ``v``, |v| < u1, for the auxiliary velocity ``c`` = v_c0."""
    mirrored = c < 0.0
    result = _smooth_right(-v if mirrored else v, abs(c), u1, u2)
    return _mirror(result) if mirrored else result


def _smooth_right(v, c, u1, u2):
    if c <= u2:
        return _free_target(v, c, u1, u2)
    delta = u1 - u2
    d = _distance(c - u1 + 1.0 / delta)
    if v > u2:
        return _region3_above(v, d, u1)
    return _bound_target(v, d, (c - u2) / (1.0 + 1.0 / (d * delta)), u1, u2)


def _free_target(v, c, u1, u2):
    w = v - c
    if abs(v) <= u2:
        return BarrierTerms(c, w, 0.5 * w * w, 0.5 * w, 1.0)
    V1 = 0.5 * w * w + _f(v, u1, u2)
    A = w + math.copysign(_slope(v, u1, u2), v)
    return BarrierTerms(c, w, V1, V1 / A, w / A)


def _bound_target(v, d, p, u1, u2):
    """v up to u2, the target ``p`` above u2 and ``d`` below u1."""
    m, y, a = u2 - v, -p / d, p / (d * (u1 - u2))
    n = p + m
    V1 = 0.5 * n * n + m * a + y * y * _psi(y, 1.0 - y) + _f(v, u1, u2)
    A = n + a + _slope(v, u1, u2)
    return BarrierTerms(u2 + p, -n, V1, -V1 / A, n / A)


def _f(v, u1, u2):
    if abs(v) <= u2:
        return 0.0
    y = (abs(v) - u2) / (u1 - u2)
    return y * y * _psi(y, (u1 - abs(v)) / (u1 - u2))


def _slope(v, u1, u2):
    """|f'(v)|."""
    if abs(v) <= u2:
        return 0.0
    return (abs(v) - u2) / ((u1 - u2) * (u1 - abs(v)))
