"""V1, V1/A and q = (v - v_c1)/A without cancellation, as the generated C evaluates them.

Why: V1 of Eq. (20) subtracts terms a hundred times its own size, and A of Eq. (10) vanishes at the
target, so the printed law jitters by metres per second squared near v_c1.  Write x = v_c1,
w = v - x, a = c - x; then a is a subgradient of f at x and

    V1 = w^2/2 + D,    D = f(v) - f(x) - a w >= 0    (the Bregman distance of f).

In every region D is a sum of non-negative terms, one of them phi(Y) = -ln(1 - Y) - Y.  Mirrored to
c >= 0, with delta = u1 - u2, gap = u1 - |v|, and d = u1 - |x|:

    region of c           x       a       v > u2 (ahead)            |v| <= u2     v < -u2 (behind)
    R1: c <= u2           c       0       Y + phi(Y)                0             Y + phi(Y)
    R2: to u2 + 1/delta   u2      c - u2  slack w + phi(Y)          a (u2 - v)    a (u2 - v)
                                                                                  + Y + phi(Y)
    R3: beyond            u1 - d  1/d     phi(w/d)                  *             2 a |v| + **

    Y = excess,    * = a (u2 - v) + phi(1 - delta/d),    ** = phi(1 - gap/d),
    excess = (|v| - u2)/delta,    slack = 1/delta - (c - u2) >= 0 in R2.

Where A vanishes at the target (R1 between -u2 and u2, R3 ahead) w is divided out of V1 and A, so
the quotients take their limits there: V1/A -> 0 and q -> 1 (R1), 0 (R2), 1/(1 + 1/d^2) (R3).

The option barrier = "smooth" has a continuous slope: f of Eq. (15) less its tangent at u2, no part
of the paper, whose f has a kink there:

    f(v) = -ln((u1 - |v|)/delta) - (|v| - u2)/delta  beyond u2, else 0

The region in which the target stays at u2 disappears (with it the jump that it gives the velocity),
the target comes nearer to the limit, and 1 <= A/(v - v_c1) stays bounded where V1 is.  The price is
about half of the pull near the limit.  In the table R2 is gone, and in R3, with p = v_c1 - u2 and d
the root of d (d + c + 1/delta - u1) = 1,

    x = u2 + p,    p = (c - u2)/(1 + 1/(d delta)),    a = p/(d delta),    |f'(v)| = Y/gap

so p, a and w keep their digits down to c = u2.  Bregman distances do not see the tangent, which is
why the rest of the table stays.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

LARGEST_TARGET = 1e150
"""|v_c0| beyond this is treated as this: its square must not overflow."""

SERIES_BELOW, SERIES_TERMS = 0.05, 12
"""phi(Y)/Y by its series where |Y| < 0.05; the first term left out is below 1e-16 of the first."""


@dataclass(frozen=True)
class Barrier:
    """Barrier quantities of one axis (m/s or rad/s).

    v_c1, w = v - v_c1, V1i, V1i/A_i, q_i, and D_i = V1i - w^2/2.
    """

    v_c1: ca.SX
    w: ca.SX
    V1: ca.SX
    V1_over_A: ca.SX
    q: ca.SX
    D: ca.SX


def stable_barrier(c: ca.SX, v: ca.SX, u1: ca.SX, u2: ca.SX) -> Barrier:
    """Barrier quantities of Eqs. (10)-(20) for v_c0 = c and |v| < u1, to full double precision.

    If both are within u2 the barrier is inactive: the first operand of each choice.
    """
    free = ca.logic_and(ca.fabs(c) <= u2, ca.fabs(v) <= u2)
    s = ca.if_else(c >= 0, 1, -1)
    axis, w = Axis(s * c, s * v, u1, u2), v - c
    return Barrier(
        ca.if_else(free, c, s * axis.x),
        ca.if_else(free, w, s * axis.w),
        ca.if_else(free, 0.5 * w * w, axis.lyapunov),
        ca.if_else(free, 0.5 * w, s * axis.quotient),
        ca.if_else(free, 1, axis.q),
        axis.bregman,
    )


def stable_minimiser(c: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """v_c1 of Eqs. (17), (18), with the distance to the limit accurate also for large |c|."""
    s = ca.if_else(c >= 0, 1, -1)
    return s * Axis(s * c, c, u1, u2).x


class Axis:
    """One axis, mirrored to c >= 0.  Each property is one line of the table above."""

    def __init__(self, c: ca.SX, v: ca.SX, u1: ca.SX, u2: ca.SX) -> None:
        self.c, self.v, self.u1, self.u2 = ca.fmin(c, LARGEST_TARGET), v, u1, u2
        self.delta, self.gap = u1 - u2, u1 - ca.fabs(v)
        self.near, self.ahead, self.behind = self.c <= u2, v > u2, v < -u2

    @cached_property
    def scaled_slack(self) -> ca.SX:
        """delta times `slack`."""
        return _boundary_slack(self.c, self.u1, self.u2)

    @cached_property
    def slack(self) -> ca.SX:
        """The part of the kink's slope that remains in R2."""
        return self.scaled_slack / self.delta

    @cached_property
    def far(self) -> ca.SX:
        """1 in R3."""
        return self.scaled_slack < 0

    @cached_property
    def outside(self) -> ca.SX:
        """1 where |v| > u2."""
        return ca.logic_or(self.ahead, self.behind)

    @cached_property
    def excess(self) -> ca.SX:
        """Share of delta by which |v| exceeds u2."""
        return (ca.fabs(self.v) - self.u2) / self.delta

    @cached_property
    def top(self) -> ca.SX:
        """Numerator of 1 - Y."""
        return ca.if_else(self.outside, self.gap, self.delta)

    @cached_property
    def smooth(self) -> ca.SX:
        """1 where A vanishes at the target."""
        inside = ca.logic_and(self.near, ca.logic_not(self.behind))
        return ca.if_else(self.ahead, self.far, inside)

    def by_region(self, near: ca.SX | float, middle: ca.SX, far: ca.SX | float) -> ca.SX:
        """The operand for the region of c: R1, R2 or R3."""
        return ca.if_else(self.near, near, ca.if_else(self.far, far, middle))

    def by_side(self, ahead: ca.SX, inside: ca.SX, behind: ca.SX) -> ca.SX:
        """The operand for the side of v."""
        return ca.if_else(self.ahead, ahead, ca.if_else(self.behind, behind, inside))

    @cached_property
    def far_slope(self) -> ca.SX:
        """1/d of R3: the positive root of d + 1/d = c - u1 + 2 d, without cancellation."""
        t = self.c - self.u1
        root, right = ca.sqrt(t * t + 4), t > 0
        return ca.if_else(right, 0.5 * (t + root), 2 / ca.if_else(right, 1, root - t))

    @cached_property
    def d(self) -> ca.SX:
        """u1 - |x| in R3."""
        return 1 / self.far_slope

    @cached_property
    def a(self) -> ca.SX:
        """Subgradient c - x."""
        return self.by_region(0, self.c - self.u2, self.far_slope)

    @cached_property
    def x(self) -> ca.SX:
        """Target v_c1."""
        return self.by_region(self.c, self.u2, self.u1 - self.d)

    @cached_property
    def w(self) -> ca.SX:
        """v - x, by exact differences wherever it can be small."""
        far = ca.if_else(self.ahead, self.d - self.gap, (self.v - self.u2) - (self.delta - self.d))
        return self.by_region(self.v - self.c, self.v - self.u2, far)

    @cached_property
    def base(self) -> ca.SX:
        """Denominator of 1 - Y: d in R3, delta elsewhere."""
        return ca.if_else(self.far, self.d, self.delta)

    @cached_property
    def y(self) -> ca.SX:
        """Y, the argument of phi."""
        return ca.if_else(
            self.far, (self.d - self.top) / self.d, ca.if_else(self.outside, self.excess, 0)
        )

    @cached_property
    def chi(self) -> ca.SX:
        """phi(Y)/Y."""
        return _chi(self.y, self.top / self.base)

    @cached_property
    def linear(self) -> ca.SX:
        """The part of D beside phi(Y)."""
        inside = self.a * (self.u2 - self.v)
        ahead = self.by_region(self.excess, self.slack * (self.v - self.u2), 0)
        behind = ca.if_else(self.far, 2 * self.a * ca.fabs(self.v), inside + self.excess)
        return self.by_side(ahead, inside, behind)

    @cached_property
    def bregman(self) -> ca.SX:
        """D, a sum of terms that are not negative."""
        return self.linear + self.y * self.chi

    @cached_property
    def lyapunov(self) -> ca.SX:
        """V1i."""
        return 0.5 * self.w * self.w + self.linear + self.y * self.chi

    @cached_property
    def divisor(self) -> ca.SX:
        """A, or A/w where both vanish at the target."""
        slope = 1 / self.gap
        curvature = slope / self.base
        ahead = ca.if_else(self.near, self.w + slope, self.slack + self.w * (1 + curvature))
        a = self.by_side(ahead, self.w - self.a, self.w - self.a - slope)
        return ca.if_else(self.smooth, 1 + ca.if_else(self.ahead, curvature, 0), a)

    @cached_property
    def quotient(self) -> ca.SX:
        """V1i/A_i."""
        divided = 0.5 * self.w + ca.if_else(self.ahead, self.chi / self.base, 0)
        return ca.if_else(self.smooth, divided, self.lyapunov) / self.divisor

    @cached_property
    def q(self) -> ca.SX:
        """(v - v_c1)/A."""
        return ca.if_else(self.smooth, 1, self.w) / self.divisor


def root(t: ca.SX, k: ca.SX) -> ca.SX:
    """The positive root d of d (d + t) = k, k > 0, without cancellation."""
    r = ca.sqrt(t * t + 4 * k)
    return ca.if_else(t > 0, 2 * k / ca.if_else(t > 0, t + r, 1), 0.5 * (r - t))


def _boundary_slack(c: ca.SX, u1: ca.SX, u2: ca.SX) -> ca.SX:
    """1 - delta (c - u2), >= 0 up to the boundary of R3, to 1e-25.

    In R2 near that boundary q is the ratio of two tiny numbers, this one among them.  The factors
    are split on grids so that every product below is exact and large parts cancel first.
    """
    bounded = ca.fmin(c, 2 * (u2 + 1 / (u1 - u2)))
    delta_1, delta_2 = _split_difference(u1, u2, 30)
    (c_1, c_rest), (u_1, u_rest) = _split(bounded, 20), _split(u2, 20)
    a_1 = c_1 - u_1
    a_2, a_3 = _split_difference(c_rest, u_rest, 36)
    slack = 1 - delta_1 * a_1
    for product in (delta_2 * a_1, delta_1 * a_2, delta_2 * a_2, delta_1 * a_3, delta_2 * a_3):
        slack = slack - product
    return slack


def _split_difference(left: ca.SX, right: ca.SX, bits: int) -> tuple[ca.SX, ca.SX]:
    """left - right as (multiple of 2^-bits, rest), both exact."""
    (left_high, left_low), (right_high, right_low) = _split(left, bits), _split(right, bits)
    return left_high - right_high, left_low - right_low


def _split(value: ca.SX, bits: int) -> tuple[ca.SX, ca.SX]:
    """(nearest multiple of 2^-bits, rest); halves keep CasADi from cancelling the big constant."""
    big = 1.5 * 2.0 ** (52 - bits)
    high = 2 * (0.5 * (value + big) - 0.5 * big)
    return high, value - high


def _chi(y: ca.SX, rest: ca.SX) -> ca.SX:
    """phi(y)/y with phi(y) = -ln(rest) - y, where rest = 1 - y to full relative accuracy."""
    small = ca.fabs(y) < SERIES_BELOW
    series = ca.SX(0)
    for order in range(SERIES_TERMS + 1, 1, -1):
        series = (series + 1 / order) * y
    closed = (ca.log(ca.if_else(small, 1, rest)) + y) / ca.if_else(small, 1, y)
    return ca.if_else(small, series, -closed)


def smooth_barrier(c: ca.SX, v: ca.SX, u1: ca.SX, u2: ca.SX) -> Barrier:
    """Barrier quantities of the smooth f for v_c0 = c and |v| < u1, to full double precision."""
    s = ca.if_else(c >= 0, 1, -1)
    axis = SmoothAxis(s * c, s * v, u1, u2)
    x, w, ratio = s * axis.x, s * axis.w, s * axis.quotient
    return Barrier(x, w, axis.lyapunov, ratio, axis.q, axis.bregman)


class SmoothAxis(Axis):
    """One axis of the smooth barrier, mirrored to c >= 0: its differences from the paper's."""

    @cached_property
    def far(self) -> ca.SX:
        """1 beyond u2."""
        return ca.logic_not(self.near)

    def by_region(self, near: ca.SX | float, middle: ca.SX | float, far: ca.SX | float) -> ca.SX:
        """The operand for the region of c; there is no middle region."""
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
        """The part of D beside phi(Y)."""
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
