"""The barrier function and its minimiser: Eqs. (10)-(20), (74)-(81)."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.barrier import paper as barrier
from wmr_ctrl.barrier.lyapunov import total_barrier
from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claim import CORRECTED, OURS, PRINTED, Claim
from wmr_ctrl.proofs.claims.common import ALL_LIMITS, OFF_EDGES, BarrierAxis
from wmr_ctrl.proofs.claims.pairs import paired_cases
from wmr_ctrl.proofs.methods.spec import Z3, Both, Refute, Ring
from wmr_ctrl.proofs.regions import AxisName, all_cases, open_cases, target_cases
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal


def _parts(flip: float) -> Statement:
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    z = v - c
    return Statement(
        a.symbols, (equal(a.V, 0.5 * z * z + barrier.f(v, u1, u2) + flip * barrier.g(c, u1, u2)),)
    )


def _spelt_out(flip: float) -> Statement:
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    at_target = 0.5 * (a.x - c) ** 2 + barrier.f(a.x, u1, u2)
    return Statement(
        a.symbols, (equal(a.V, 0.5 * (v - c) ** 2 + barrier.f(v, u1, u2) - flip * at_target),)
    )


def _two_axes(flip: float) -> Statement:
    one, two = BarrierAxis("1"), BarrierAxis("2")
    columns = [ca.vertcat(x, y) for x, y in zip(one.all, two.all, strict=True)]
    return Statement(
        {**one.symbols, **two.symbols}, (equal(total_barrier(*columns), one.V + flip * two.V),)
    )


def _minimum(flip: float) -> Statement:
    """V1 = J(v) - J(v_c1); as it is at least half the squared distance, v_c1 is the minimum."""
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    cost = 0.5 * (v - c) ** 2 + barrier.f(v, u1, u2)
    least = 0.5 * (a.x - c) ** 2 + barrier.f(a.x, u1, u2)
    return Statement(
        a.symbols, (at_least(cost - least, flip * 0.5 * a.w**2 if flip > 0 else 0.6 * a.w**2),)
    )


def _slope_sign(flip: float) -> Statement:
    a = BarrierAxis()
    share = 1 if flip > 0 else 1.25
    return Statement(a.symbols, (at_least((a.A - share * a.w) * a.w),), a.inside)


def _inside(flip: float) -> Statement:
    a = BarrierAxis()
    _, _, u1, u2 = a.all
    limit = u1 if flip > 0 else u2
    return Statement(a.symbols, (above(limit, a.x), above(a.x, -limit)), a.inside)


def _stationary(flip: float) -> Statement:
    """The far branch of (18) is where the slope vanishes: w + 1/(u1 - w) = |v_c0|."""
    a = BarrierAxis()
    _, c, u1, _ = a.all
    size = ca.fabs(a.x)
    return Statement(a.symbols, (equal(size + flip / (u1 - size), ca.fabs(c)),))


def _slope(flip: float) -> Statement:
    """Eq. (74)."""
    a = BarrierAxis()
    return Statement(a.symbols, (equal(ca.gradient(a.V, a.all[0]), flip * a.A),))


def _curvature(flip: float) -> Statement:
    """Eq. (75)."""
    a = BarrierAxis()
    v, _, u1, u2 = a.all
    second = ca.hessian(a.V, v)[0]
    bend = ca.if_else(barrier.h(v, u2), flip / (u1 - ca.fabs(v)) ** 2, 0)
    return Statement(a.symbols, (equal(second, 1 + bend), at_least(second, 1)))


def _half_square(flip: float) -> Statement:
    """Eqs. (76), (77)."""
    a = BarrierAxis()
    v = a.all[0]
    square = 0.5 * a.w**2
    return Statement(
        a.symbols, (equal(ca.gradient(square, v), flip * a.w), equal(ca.hessian(square, v)[0], 1))
    )


def _zero_at_target(flip: float) -> Statement:
    """Eq. (78)."""
    a = BarrierAxis()
    _, c, u1, u2 = a.all
    return Statement(a.symbols, (equal(barrier.lyapunov(flip * a.x, c, u1, u2)),))


def _flat_at_target(flip: float) -> Statement:
    """Eq. (79)."""
    a = BarrierAxis()
    _, c, u1, u2 = a.all
    return Statement(a.symbols, (equal(barrier.a_term(a.x, flip * c, u1, u2)),))


def _curvatures_compared(flip: float) -> Statement:
    """Eq. (80)."""
    a = BarrierAxis()
    v = a.all[0]
    second, plain = ca.hessian(a.V, v)[0], ca.hessian(0.5 * a.w**2, v)[0]
    return Statement(a.symbols, (at_least(second, (1 if flip > 0 else 1.5) * plain), above(plain)))


def _lower_bound(flip: float) -> Statement:
    """Eq. (81)."""
    a = BarrierAxis()
    return Statement(a.symbols, (at_least(a.V, (0.5 if flip > 0 else 0.6) * a.w**2),))


ONE, TWO = AxisName("1"), AxisName("2")
PAIRS = paired_cases(ONE, TWO)
SMOOTH = tuple(c for c in target_cases(edges=False) if "middle" not in c.label)
FAR = tuple(c for c in target_cases(edges=False) if "far" in c.label)
IN_R2 = (at(c=3, u1=1, u2="4/5"),)

CLAIMS = (
    Claim(
        "eq12",
        (12, 13, 14, 15, 16),
        PRINTED,
        "V1i = z^2/2 + f(v) + g(v_c0) with z = v - v_c0",
        "The function that the laws make smaller is the paper's.",
        ALL_LIMITS,
        _parts,
        Ring(all_cases()),
    ),
    Claim(
        "eq19",
        (19,),
        PRINTED,
        "V1 = V11 + V12",
        "Each axis can be judged by itself.",
        OFF_EDGES,
        _two_axes,
        Ring(PAIRS, spare=12),
    ),
    Claim(
        "eq20",
        (20,),
        PRINTED,
        "V1i = (v - v_c0)^2/2 + f(v) - (v_c1 - v_c0)^2/2 - f(v_c1)",
        "The barrier function measures how much worse the present velocity is than the best "
        "allowed one.",
        ALL_LIMITS,
        _spelt_out,
        Ring(all_cases()),
    ),
    Claim(
        "eq17-18",
        (17, 18),
        PRINTED,
        "v_c1 of (18) is the one and only minimiser of (v - v_c0)^2/2 + f(v): "
        "the cost exceeds its value there by at least (v - v_c1)^2/2",
        "The target velocity is the best one that the limit allows, and there is no second best.",
        ALL_LIMITS,
        _minimum,
        Ring(all_cases(), log_lemma=True),
        premises=("lemma.log",),
    ),
    Claim(
        "eq17-18.slope",
        (10, 18),
        OURS,
        "(A - (v - v_c1)) (v - v_c1) >= 0: the cost falls towards v_c1 from "
        "either side, at least as fast as the distance",
        "There is no valley in which the velocity could get stuck.",
        ALL_LIMITS,
        _slope_sign,
        Both(Ring(all_cases()), Z3()),
    ),
    Claim(
        "eq18.inside",
        (18,),
        OURS,
        "|v_c1| < v_u1 for every v_c0",
        "However far away the robot is, it never aims beyond its speed limit.",
        ALL_LIMITS,
        _inside,
        Both(Ring(target_cases()), Z3()),
    ),
    Claim(
        "eq18.stationary",
        (18,),
        PRINTED,
        "beyond v_u2 + 1/(v_u1 - v_u2) the root of (18) solves |v_c1| + 1/(v_u1 - |v_c1|) = |v_c0|",
        "The formula with the root is right.",
        "every 0 < v_u2 < v_u1, |v_c0| beyond v_u2 + 1/(v_u1 - v_u2)",
        _stationary,
        Ring(FAR),
    ),
    Claim(
        "eq74",
        (10, 74),
        PRINTED,
        "dV1i/dv = A_i",
        "A is the slope of the barrier function.",
        OFF_EDGES,
        _slope,
        Ring(open_cases()),
    ),
    Claim(
        "eq75",
        (11, 75),
        PRINTED,
        "d2V1i/dv2 = 1 + h/(v_u1 - |v|)^2 >= 1 (the printed indices mix the axes)",
        "The barrier function is at least as curved as a plain square.",
        OFF_EDGES,
        _curvature,
        Ring(open_cases()),
    ),
    Claim(
        "eq76-77",
        (76, 77),
        PRINTED,
        "d/dv (v - v_c1)^2/2 = v - v_c1, and its second derivative is 1",
        "Reference curve for the comparison with the barrier.",
        ALL_LIMITS,
        _half_square,
        Ring(open_cases()),
    ),
    Claim(
        "eq78",
        (78,),
        PRINTED,
        "V1i = 0 at v = v_c1",
        "The target velocity has the value 0.",
        ALL_LIMITS,
        _zero_at_target,
        Ring(target_cases()),
    ),
    Claim(
        "eq79.printed",
        (79,),
        PRINTED,
        "dV1i/dv = 0 at v = v_c1",
        "False in the middle region: there the barrier function has a corner at the target, like "
        "|v - v_u2|.",
        "every v_c0",
        _flat_at_target,
        Refute(IN_R2),
    ),
    Claim(
        "eq79",
        (79,),
        CORRECTED,
        "dV1i/dv = 0 at v = v_c1 for |v_c0| < v_u2 and beyond v_u2 + 1/(v_u1 - v_u2)",
        "Outside the middle region the barrier function is smooth at the target.",
        "|v_c0| < v_u2 or |v_c0| > v_u2 + 1/(v_u1 - v_u2)",
        _flat_at_target,
        Ring(SMOOTH),
    ),
    Claim(
        "eq80",
        (80,),
        PRINTED,
        "d2V1i/dv2 >= d2/dv2 (v - v_c1)^2/2 > 0",
        "The barrier function is convex.",
        OFF_EDGES,
        _curvatures_compared,
        Ring(open_cases()),
    ),
    Claim(
        "eq81",
        (81,),
        PRINTED,
        "V1i >= (v - v_c1)^2/2, in spite of (79), on which the paper's own argument rests",
        "If the barrier function is small, the velocity is near its target.",
        ALL_LIMITS,
        _lower_bound,
        Ring(all_cases(), log_lemma=True),
        premises=("lemma.log",),
    ),
)
