"""The barrier's proximal map X_k, and the transport of a velocity along level sets of V1.

    X_k(c) = argmin over x of (x - c)^2/2 + k f(x),      |x| < u1

for the barrier f of Eqs. (14), (15): the nearest velocity inside the limit, with f weighed by k;
X_1 is v_c1 of Eq. (18).  Mirrored to c >= 0, with delta = u1 - u2:

    paper's f     c <= u2: c     c <= u2 + k/delta: u2    beyond: u1 - d,  t = c - u1
    smooth f      c <= u2: c                              beyond: u1 - d,  t = c - u1 + k/delta

where d is the positive root of d (d + t) = k.  X_k is nonexpansive and defined for every c.

Transport from target c to target c+ on one axis, with x = X_1(c), x+ = X_1(c+), w = v - x,
V0 = V1(v; c) and D1 = V1(x+ + w; c+) - w^2/2:

    theta = min(1, 2 V0/(D1 + sqrt(D1^2 + 2 w^2 V0)))
    v*    = v                   where the target is held, or comes nearer by a <= (1 - theta)|w|
            x+ + theta w        elsewhere

V1(.; c+) is convex and 0 at x+, so V1(x+ + theta w; c+) <= theta^2 w^2/2 + theta D1 <= V0, and a
target that comes nearer lowers V1 by itself: V1(v*; c+) <= V0 and |v* - x+| <= |w|.  Below v_u2
theta is 1.  Where x+ + w lies beyond the limit, theta is 0; where v itself does, V0 is infinite,
and theta is 0 or 1 so that v* has no jump as v enters.
"""

import casadi as ca

from .stable import root, smooth_barrier, stable_barrier

LARGEST = 1e150
"""|c| beyond this is treated as this: its square must not overflow."""


def resolvent(c: ca.SX, k: ca.SX, u1: ca.SX, u2: ca.SX, smooth: bool = False) -> ca.SX:
    """X_k(c) [m/s or rad/s] for k > 0 [m2/s2 or rad2/s2], to full relative accuracy of u1 - |x|."""
    size = ca.fmin(ca.if_else(c >= 0, 1, -1) * c, LARGEST)  # fabs has no slope at 0
    delta = u1 - u2
    if smooth:
        d = root(size - u1 + k / delta, k)
        beyond = (size - u2) * d * delta / (d * delta + k)  # (c - u2)/(1 + k/(d delta)), 0 at u2
        x = ca.if_else(size <= u2, size, u2 + beyond)
    else:
        far = u1 - root(size - u1, k)
        x = ca.if_else(size <= u2, size, ca.if_else(size <= u2 + k / delta, u2, far))
    return ca.if_else(c >= 0, x, -x)


def transported(
    v: ca.SX, c: ca.SX, c_next: ca.SX, limits: tuple[ca.SX, ca.SX], smooth: bool = False
) -> ca.SX:
    """Transported velocity v* [m/s or rad/s] for limits (u1, u2), for every v and c."""
    u1 = limits[0]
    x, x_next = (resolvent(target, ca.SX(1), *limits, smooth) for target in (c, c_next))
    form = smooth_barrier if smooth else stable_barrier
    ahead = x_next + (v - x)
    within, reaches = ca.fabs(v) < u1, ca.fabs(ahead) < u1
    level = form(c, ca.if_else(within, v, 0), *limits).V1
    excess = form(c_next, ca.if_else(reaches, ahead, 0), *limits).D
    nearer = ca.if_else(v > x, x_next - x, x - x_next)
    share = ca.if_else(
        within,
        ca.if_else(reaches, level_share(v - x, level, excess), 0),
        ca.if_else(nearer > 0, 0, 1),
    )
    return ca.if_else(ca.eq(c_next, c), v, carried(v, x, x_next, nearer, share))


def level_share(w: ca.SX, level: ca.SX, excess: ca.SX) -> ca.SX:
    """theta: largest number up to 1 with theta^2 w^2/2 + theta D1 <= V0; 1 if both w and D1
    are 0.
    """
    square = excess * excess + 2 * level * w * w
    some = square > 0
    divisor = excess + ca.sqrt(ca.if_else(some, square, 1))
    return ca.if_else(some, ca.fmin(1, 2 * level / ca.if_else(some, divisor, 1)), 1)


def carried(v: ca.SX, x: ca.SX, x_next: ca.SX, nearer: ca.SX, share: ca.SX) -> ca.SX:
    """v*: v if the target approaches it by at most (1 - theta)|w|, else x+ + theta w."""
    w = v - x
    left = ca.fabs(w) - nearer
    stays = ca.logic_and(nearer > 0, left >= share * ca.fabs(w))
    return ca.if_else(stays, v, x_next + share * w)
