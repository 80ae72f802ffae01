"""The smooth barrier as compiled: where it aims, that A is the slope of V1, how far A/w goes."""

from collections.abc import Iterator, Mapping
from typing import Any

import casadi as ca

from wmr_ctrl.barrier.lyapunov import smooth_f, smooth_lyapunov
from wmr_ctrl.barrier.proximal import resolvent
from wmr_ctrl.barrier.stable import Barrier, smooth_barrier
from wmr_ctrl.proofs.case import POSITIVE, Case
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import (
    ALL_LIMITS,
    CLOSED_FORM,
    FINITE,
    NO_SERIES,
    BarrierAxis,
    barrier_axis,
)
from wmr_ctrl.proofs.methods.spec import Ring
from wmr_ctrl.proofs.regions import CHARTED, SIDE_EDGES, SIDES, side_value, smooth_cases
from wmr_ctrl.proofs.statement import Statement, at_least, equal, symbols


def _compiled(a: BarrierAxis) -> Barrier:
    v, c, u1, u2 = a.all
    return smooth_barrier(c, v, u1, u2)


def _pairs() -> Iterator[Case]:
    """y and v each on one of its sides; v off the corner, where the slope is 0 from both sides."""
    for y_side in (*SIDES, *SIDE_EDGES):
        for v_side in SIDES:
            yield _pair(y_side, v_side)


def _pair(y_side: str, v_side: str) -> Case:
    names = {"u2": POSITIVE, "b": POSITIVE}
    names |= {n: POSITIVE for n, s in (("k", y_side), ("i", v_side)) if s[:-1] in CHARTED}

    def values(n: Mapping[str, Any]) -> dict[str, Any]:
        u2, b = n["u2"], n["b"]
        y, v = (side_value(side, u2, b, n.get(k, 0)) for side, k in ((y_side, "k"), (v_side, "i")))
        return {"u1": u2 + b, "u2": u2, "y": y, "v": v}

    return Case(f"y {y_side}, v {v_side}", names, values)


EVERY = smooth_cases()
OFF_CORNERS = tuple(
    c
    for c in EVERY
    if c.label != "v_c0 zero, v zero" and "corner" not in c.label and "kink" not in c.label
)
claim = Claims(by=Ring(EVERY, CLOSED_FORM), given=ALL_LIMITS + FINITE)


@claim("smooth.V1", given=ALL_LIMITS + NO_SERIES, premises="cover.smooth-targets cover.beyond")
def value(mutation: Mutation) -> Statement:
    """smooth barrier: the compiled V1i equals (20) with f(v) = -ln((v_u1 - |v|)/(v_u1 - v_u2)) -
    (|v| - v_u2)/(v_u1 - v_u2) beyond v_u2, else 0.

    The sum of non-negative terms is the same function.
    """
    a = BarrierAxis()
    return a.states(equal(_compiled(a).V1, mutation * smooth_lyapunov(*a.all)))


@claim(
    "smooth.convex",
    given="every 0 < v_u2 < v_u1, |v| and |y| < v_u1; |v| = v_u2 left out",
    by=Ring(tuple(_pairs()), log_lemma=True),
    premises="lemma.log",
)
def above_tangent(mutation: Mutation) -> Statement:
    """smooth barrier: f(y) >= f(v) + f'(v) (y - v).

    The smooth barrier function lies above each of its tangents.
    """
    t = symbols("y v u1 u2", "u1 u2")
    y, v, u1, u2 = t.values()
    line = smooth_f(v, u1, u2) + ca.gradient(smooth_f(v, u1, u2), v) * (y - v)
    return Statement(t, (at_least(smooth_f(y, u1, u2), line + mutation(0, (y - v) ** 2)),))


@claim(
    "smooth.v_c1", by=Ring(EVERY), premises="prox.optimal-smooth cover.smooth-targets cover.beyond"
)
def target(mutation: Mutation) -> Statement:
    """smooth barrier: the compiled v_c1 is X_1(v_c0), and w = v - v_c1.

    The generated code aims at the nearest velocity inside the limit.
    """
    a, v, c, u1, u2 = barrier_axis()
    found, nearest = _compiled(a), resolvent(c, ca.SX(1), u1, u2, smooth=True)
    return a.states(equal(found.v_c1, mutation * nearest), equal(found.w, v - nearest))


@claim(
    "smooth.slope",
    given="every 0 < v_u2 < v_u1, |v| < v_u1, any v_c0; off |v| = v_u2 and |v_c0| = v_u2, "
    "and v = v_c0 = 0 left out" + NO_SERIES,
    by=Ring(OFF_CORNERS, CLOSED_FORM),
    premises="cover.smooth-targets cover.beyond",
)
def slope(mutation: Mutation) -> Statement:
    """smooth barrier: (v - v_c1)/q is dV1i/dv, the slope A of the compiled V1i.

    What the laws divide by is the slope of the barrier function.
    """
    a = BarrierAxis()
    found = _compiled(a)
    return a.states(equal(found.q * ca.gradient(found.V1, a.all[0]), mutation * found.w))


@claim(
    "smooth.quotient", given=ALL_LIMITS + NO_SERIES, premises="cover.smooth-targets cover.beyond"
)
def quotient(mutation: Mutation) -> Statement:
    """smooth barrier: the compiled V1i/A times A = (v - v_c1)/q equals V1i.

    The feedback term is the quotient of the two.
    """
    a = BarrierAxis()
    found = _compiled(a)
    return a.states(equal(found.V1_over_A * found.w, mutation * found.q * found.V1))


@claim(
    "prox.smooth-ratio", by=Ring(EVERY), premises="smooth.slope cover.smooth-targets cover.beyond"
)
def ratio(mutation: Mutation) -> Statement:
    """smooth barrier: 1 <= A/(v - v_c1) <= 1 + 1/(v_u1 - max(|v|, |v_c1|))^2, as compiled (1/q).

    The network's regressor is bounded where V1 is.
    """
    a, v, _, u1, _ = barrier_axis()
    found = _compiled(a)
    m = ca.fmax(ca.fabs(v), ca.fabs(found.v_c1))
    top = (1 + mutation(1, 0.9) / (u1 - m) ** 2) * found.q
    return a.states(at_least(1, found.q), at_least(top, 1))
