"""What C evaluates equals the paper's functions; what the series leaves out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca

from wmr_ctrl.barrier import stable
from wmr_ctrl.proofs.case import POSITIVE, Case
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.common import (
    ALL_LIMITS,
    CLOSED_FORM,
    FINITE,
    NO_SERIES,
    BarrierAxis,
)
from wmr_ctrl.proofs.methods.spec import Ring
from wmr_ctrl.proofs.regions import all_cases, target_cases
from wmr_ctrl.proofs.statement import Statement, at_least, equal, symbols


def _target(flip: float) -> Statement:
    a = BarrierAxis()
    _, c, u1, u2 = a.all
    only = stable.stable_minimiser(c, u1, u2)
    return Statement(a.symbols, (equal(only, flip * a.x),))


def _distance(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(
        a.symbols, (equal(a.stable.w, a.all[0] - flip * a.x), equal(a.stable.v_c1, a.x))
    )


def _value(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (equal(a.stable.V1, flip * a.V),))


def _quotient(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (equal(a.stable.V1_over_A * a.A, flip * a.V),))


def _q(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (equal(a.stable.q * a.A, flip * a.w),))


def _series_slope(flip: float) -> Statement:
    """R = phi(y) - y chi(y) with chi the compiled series: |R'| <= 2^-51 |y| for |y| < 0.05."""
    t = symbols("y")
    y = t["y"]
    chi = stable._chi(y, 1 - y)
    slope = (1 / (1 - y) - 1) - ca.gradient(y * chi, y)
    bound = (2.0**-51 if flip > 0 else 2.0**-56) * ca.fabs(y)
    return Statement(t, (at_least(bound, slope), at_least(bound, -slope)))


def _closed_slope(flip: float) -> Statement:
    """The closed form: d/dy (y chi(y)) = phi'(y) exactly."""
    t = symbols("y")
    y = t["y"]
    return Statement(t, (equal(ca.gradient(y * stable._chi(y, 1 - y), y), 1 / (1 - y) - flip),))


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

CLAIMS = (
    Claim(
        "forms.v_c1",
        (18,),
        OURS,
        "the compiled v_c1 equals (18)",
        "The generated code aims where the paper aims.",
        ALL_LIMITS + "; |v_c0| < 1e100",
        _target,
        Ring(target_cases()),
    ),
    Claim(
        "forms.w",
        (18,),
        OURS,
        "the compiled v - v_c1 is the difference of v and (18)",
        "The distance to the target is right even where it is computed in another way.",
        ALL_LIMITS + "; |v_c0| < 1e100",
        _distance,
        Ring(all_cases()),
    ),
    Claim(
        "forms.V1",
        (12, 20),
        OURS,
        "the compiled V1i, a sum of non-negative terms, equals (20)",
        "No cancellation of large numbers, and still the same function.",
        ALL_LIMITS + NO_SERIES,
        _value,
        EVERYWHERE,
    ),
    Claim(
        "forms.quotient",
        (9, 20),
        OURS,
        "the compiled V1i/A_i times A_i equals V1i",
        "The feedback term is the paper's, without a division by A = 0.",
        ALL_LIMITS + NO_SERIES,
        _quotient,
        EVERYWHERE,
    ),
    Claim(
        "forms.q",
        (9, 10),
        OURS,
        "the compiled q times A_i equals v - v_c1",
        "The feed-forward factor is the paper's, with its limit at A = 0.",
        ALL_LIMITS + FINITE,
        _q,
        EVERYWHERE,
    ),
    Claim(
        "forms.closed",
        (15,),
        OURS,
        "for |y| >= 0.05 the derivative of the compiled y chi(y) is that of phi(y) = "
        "-ln(1 - y) - y",
        "The closed form is the logarithm of the paper.",
        "0.05 <= |y|, y < 1",
        _closed_slope,
        Ring(BEYOND, CLOSED_FORM),
    ),
    Claim(
        "forms.series",
        (15,),
        OURS,
        "for |y| < 0.05 the compiled series has a derivative within 2^-51 |y| of "
        "phi'(y); integrated from 0, it is within 2^-52 y^2 of phi(y), about one part in 2^51",
        "Where the logarithm would lose digits a series replaces it; the two cannot be told apart "
        "in double "
        "precision.",
        "0 < |y| < 0.05, coefficients as the doubles that they are",
        _series_slope,
        Ring((_within(1), _within(-1))),
        premises=("lemma.integration",),
    ),
)
