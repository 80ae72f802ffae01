"""Level transport: a velocity carried along with its target, and V1 does not rise.

From target c to target c+ on one axis, with x = X_1(c), x+ = X_1(c+), w = v - x, V0 = V1(v; c) and
D1 = V1(x+ + w; c+) - w^2/2:

    theta = min(1, 2 V0/(D1 + sqrt(D1^2 + 2 w^2 V0)))
    v*    = v                   where the target is held, or comes nearer by a <= (1 - theta)|w|
            x+ + theta w        elsewhere

V1(.; c+) is convex and 0 at x+, so V1(x+ + theta w; c+) <= theta^2 w^2/2 + theta D1 <= V0, and a
target that comes nearer lowers V1 by itself: V1(v*; c+) <= V0 and |v* - x+| <= |w|.  Below v_u2
theta is 1.  Where x+ + w lies beyond the limit, theta is 0; where v itself does, V0 is infinite,
and theta is 0 or 1 so that v* has no jump as v enters.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.barrier.resolvent import resolvent
from wmr_ctrl.barrier.smooth import smooth_barrier
from wmr_ctrl.barrier.stable import stable_barrier


def transported(
    v: ca.SX, c: ca.SX, c_next: ca.SX, limits: tuple[ca.SX, ca.SX], smooth: bool = False
) -> ca.SX:
    """v* [m/s or rad/s] for limits (u1, u2); every v and c are allowed."""
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
    """theta: the largest share of 1 with theta^2 w^2/2 + theta D1 <= V0; 1 where both are 0."""
    square = excess * excess + 2 * level * w * w
    some = square > 0
    divisor = excess + ca.sqrt(ca.if_else(some, square, 1))
    return ca.if_else(some, ca.fmin(1, 2 * level / ca.if_else(some, divisor, 1)), 1)


def carried(v: ca.SX, x: ca.SX, x_next: ca.SX, nearer: ca.SX, share: ca.SX) -> ca.SX:
    """v*: v where the target comes nearer by at most (1 - theta)|w|, else x+ + theta w."""
    w = v - x
    left = ca.fabs(w) - nearer
    stays = ca.logic_and(nearer > 0, left >= share * ca.fabs(w))
    return ca.if_else(stays, v, x_next + share * w)
