"""Compiled forms equal the paper's functions; truncation of the series."""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from wmr_ctrl.barrier import stable
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
from wmr_ctrl.proofs.regions import all_cases, target_cases
from wmr_ctrl.proofs.statement import Statement, at_least, equal, symbols


def _within(sign: int) -> Case:
    """0 < |y| < 0.05: y = n/(20 n + m)."""

    def values(n: Mapping[str, Any]) -> dict[str, Any]:
        return {"y": sign * n["n"] / (20 * n["n"] + n["m"])}

    return Case(
        f"{'0 < y < 0.05' if sign > 0 else '-0.05 < y < 0'}", {"n": POSITIVE, "m": POSITIVE}, values
    )


BEYOND = (
    Case("0.05 < y < 1", {"n": POSITIVE}, lambda n: {"y": (n["n"] + 1) / (n["n"] + 20)}),
    Case("y < -0.05", {"n": POSITIVE}, lambda n: {"y": -n["n"] - 1}),
    Case("-1 < y < -0.05", {"n": POSITIVE}, lambda n: {"y": -(n["n"] + 1) / (n["n"] + 20)}),
)
EVERYWHERE = Ring(all_cases(), CLOSED_FORM)
claim = Claims(by=EVERYWHERE)


@claim("forms.v_c1", (18,), given=ALL_LIMITS + "; |v_c0| < 1e100", by=Ring(target_cases()))
def target(mutation: Mutation) -> Statement:
    """the compiled v_c1 equals (18).

    The generated code aims where the paper aims.
    """
    a, _, c, u1, u2 = barrier_axis()
    return a.states(equal(stable.stable_minimiser(c, u1, u2), mutation * a.x))


@claim("forms.w", (18,), given=ALL_LIMITS + "; |v_c0| < 1e100", by=Ring(all_cases()))
def distance(mutation: Mutation) -> Statement:
    """the compiled v - v_c1 is the difference of v and (18).

    The distance to the target is right even where it is computed in another way.
    """
    a = BarrierAxis()
    return a.states(equal(a.stable.w, a.all[0] - mutation * a.x), equal(a.stable.v_c1, a.x))


@claim("forms.V1", (12, 20), given=ALL_LIMITS + NO_SERIES)
def value(mutation: Mutation) -> Statement:
    """the compiled V1i, a sum of non-negative terms, equals (20).

    No cancellation of large numbers, and still the same function.
    """
    a = BarrierAxis()
    return a.states(equal(a.stable.V1, mutation * a.V))


@claim("forms.quotient", (9, 20), given=ALL_LIMITS + NO_SERIES)
def quotient(mutation: Mutation) -> Statement:
    """the compiled V1i/A_i times A_i equals V1i.

    The feedback term is the paper's, without a division by A = 0.
    """
    a = BarrierAxis()
    return a.states(equal(a.stable.V1_over_A * a.A, mutation * a.V))


@claim("forms.q", (9, 10), given=ALL_LIMITS + FINITE)
def q(mutation: Mutation) -> Statement:
    """the compiled q times A_i equals v - v_c1.

    The feed-forward factor is the paper's, with its limit at A = 0.
    """
    a = BarrierAxis()
    return a.states(equal(a.stable.q * a.A, mutation * a.w))


@claim("forms.closed", (15,), given="0.05 <= |y|, y < 1", by=Ring(BEYOND, CLOSED_FORM))
def closed_slope(mutation: Mutation) -> Statement:
    """for |y| >= 0.05 the derivative of the compiled y chi(y) is that of phi(y) = -ln(1 - y) - y.

    The closed form is the logarithm of the paper.
    """
    t = symbols("y")
    y = t["y"]
    return Statement(t, (equal(ca.gradient(y * stable._chi(y, 1 - y), y), 1 / (1 - y) - mutation),))


@claim(
    "forms.series",
    (15,),
    given="0 < |y| < 0.05, coefficients as the doubles that they are",
    by=Ring((_within(1), _within(-1))),
    premises="lemma.integration",
)
def series_slope(mutation: Mutation) -> Statement:
    """for |y| < 0.05 the compiled series has a derivative within 2^-51 |y| of phi'(y); integrated
    from 0, it is within 2^-52 y^2 of phi(y), about one part in 2^51.

    Where the logarithm would lose digits a series replaces it; the two cannot be told apart in
    double precision.
    """
    t = symbols("y")
    y = t["y"]
    chi = stable._chi(y, 1 - y)
    slope = (1 / (1 - y) - 1) - ca.gradient(y * chi, y)
    bound = mutation(2.0**-51, 2.0**-56) * ca.fabs(y)
    return Statement(t, (at_least(bound, slope), at_least(bound, -slope)))
