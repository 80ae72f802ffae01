"""Barrier function whose slope is continuous: f = -ln((u1 - |v|)/delta) - (|v| - u2)/delta.

For c = v_c0 >= 0 the minimiser is c up to u2 and u2 + p beyond, without a dead zone at u2.
"""

from tests.oracle.barrier import distance, mirrored, psi, region1, region3


def smooth_barrier(v, c, u1, u2):
    """Barrier terms at speed ``v``, |v| < u1, for the auxiliary velocity ``c`` = v_c0."""
    return mirrored(_smooth_right, v, c, u1, u2)


def _smooth_right(v, c, u1, u2):
    delta, rest = u1 - u2, u1 - abs(v)
    y = max(abs(v) - u2, 0.0) / delta
    f, slope = y * y * psi(y, rest / delta), y / rest
    if c <= u2:
        return region1(v, c, f, slope)
    d = distance(c - u1 + 1.0 / delta)
    p = (c - u2) / (1.0 + 1.0 / (d * delta))
    return region3(v, d, p, p / (d * delta), f, slope, u1, u2)
