"""The barrier with a continuous slope: V1, V1/A and q of the option barrier = "smooth".

Source: f of Eq. (15) less its tangent at u2; no part of the paper, whose f has a kink there.

    f(v) = -ln((u1 - |v|)/delta) - (|v| - u2)/delta  beyond u2, else 0

What that changes: the region in which the target stays at u2 disappears (with it the jump that it
gives the velocity), the target comes nearer to the limit, and 1 <= A/(v - v_c1) stays bounded where
V1 is.  The price is about half of the pull near the limit.  In the table of `stable_barrier` R2 is
gone, and in R3, with p = v_c1 - u2 and d the root of d (d + c + 1/delta - u1) = 1,

    x = u2 + p,    p = (c - u2)/(1 + 1/(d delta)),    a = p/(d delta),    |f'(v)| = Y/gap

so p, a and w keep their digits down to c = u2.  Bregman distances do not see the tangent, which is
why the rest of the table stays.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca

from wmr_ctrl.barrier.resolvent import root
from wmr_ctrl.barrier.stable import Axis, Barrier


def smooth_barrier(c: ca.SX, v: ca.SX, u1: ca.SX, u2: ca.SX) -> Barrier:
    """Barrier quantities of the smooth f for v_c0 = c and |v| < u1, to full double precision."""
    s = ca.if_else(c >= 0, 1, -1)
    axis = SmoothAxis(s * c, s * v, u1, u2)
    x, w, ratio = s * axis.x, s * axis.w, s * axis.quotient
    return Barrier(x, w, axis.lyapunov, ratio, axis.q, axis.bregman)


class SmoothAxis(Axis):
    """One axis, mirrored to c >= 0; what differs from the paper's barrier."""

    def __init__(self, c: ca.SX, v: ca.SX, u1: ca.SX, u2: ca.SX) -> None:
        super().__init__(c, v, u1, u2)
        self.far = ca.logic_not(self.near)
        self.smooth = ca.if_else(
            self.ahead, self.far, ca.logic_and(self.near, ca.logic_not(self.behind))
        )

    def by_region(self, near: ca.SX | float, middle: ca.SX | float, far: ca.SX | float) -> ca.SX:
        """The operand of the region that c is in; there is no middle one."""
        return ca.if_else(self.near, near, far)

    @cached_property
    def d(self) -> ca.SX:
        """u1 - |x| beyond u2."""
        return root(self.c - self.u1 + 1 / self.delta, ca.SX(1))

    @cached_property
    def p(self) -> ca.SX:
        """x - u2 beyond u2."""
        product = self.d * self.delta
        return (self.c - self.u2) * product / (product + 1)

    @cached_property
    def a(self) -> ca.SX:
        """Subgradient c - x = f'(x)."""
        return self.by_region(0, 0, self.p / (self.d * self.delta))

    @cached_property
    def x(self) -> ca.SX:
        """Target v_c1."""
        return self.by_region(self.c, 0, self.u2 + self.p)

    @cached_property
    def w(self) -> ca.SX:
        """v - x."""
        far = ca.if_else(self.ahead, self.d - self.gap, (self.v - self.u2) - self.p)
        return self.by_region(self.v - self.c, 0, far)

    @cached_property
    def linear(self) -> ca.SX:
        """What D has beside phi(Y)."""
        inside = self.a * (self.u2 - self.v)
        behind = 2 * self.a * ca.fabs(self.v)
        return self.by_side(ca.SX(0), inside, behind)

    @cached_property
    def divisor(self) -> ca.SX:
        """A, or A/w where both vanish at the target."""
        curvature = 1 / (self.gap * self.base)
        slope = ca.if_else(self.outside, self.excess / self.gap, 0)
        a = self.w - self.a + ca.if_else(self.v < 0, -slope, slope)
        return ca.if_else(self.smooth, 1 + ca.if_else(self.ahead, curvature, 0), a)
