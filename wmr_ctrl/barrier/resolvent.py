"""X_k: the nearest velocity inside the limit, with the barrier weighed by k.

    X_k(c) = argmin over x of (x - c)^2/2 + k f(x),      |x| < u1

is the proximal map of the barrier f of Eqs. (14), (15); X_1 is v_c1 of Eq. (18).  Mirrored to
c >= 0, with delta = u1 - u2:

    paper's f     c <= u2: c     c <= u2 + k/delta: u2    beyond: u1 - d,  t = c - u1
    smooth f      c <= u2: c                              beyond: u1 - d,  t = c - u1 + k/delta

where d is the positive root of d (d + t) = k.  Never expansive, and defined for every c.
"""

from __future__ import annotations

import casadi as ca

LARGEST = 1e150
"""|c| beyond this is treated as this: its square must not overflow."""


def resolvent(c: ca.SX, k: ca.SX, u1: ca.SX, u2: ca.SX, smooth: bool = False) -> ca.SX:
    """X_k(c) [m/s or rad/s] for k > 0 [m2/s2 or rad2/s2], to full relative accuracy of u1 - |x|."""
    size = ca.fmin(ca.if_else(c >= 0, 1, -1) * c, LARGEST)  # fabs has no slope at 0
    delta = u1 - u2
    if smooth:
        far = u2 + _beyond(size, k, u1, u2)
        x = ca.if_else(size <= u2, size, far)
    else:
        far = u1 - root(size - u1, k)
        x = ca.if_else(size <= u2, size, ca.if_else(size <= u2 + k / delta, u2, far))
    return ca.if_else(c >= 0, x, -x)


def root(t: ca.SX, k: ca.SX) -> ca.SX:
    """The positive root d of d (d + t) = k, k > 0, without cancellation."""
    r = ca.sqrt(t * t + 4 * k)
    return ca.if_else(t > 0, 2 * k / ca.if_else(t > 0, t + r, 1), 0.5 * (r - t))


def _beyond(size: ca.SX, k: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """x - u2 under the smooth barrier: (c - u2)/(1 + k/(d delta)), which is 0 at c = u2."""
    delta = u1 - u2
    d = root(size - u1 + k / delta, k)
    return (size - u2) * d * delta / (d * delta + k)
