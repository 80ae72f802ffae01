"""Rounding of the command filter: clip and governor as the compiled text computes them.

A computed number is whatever roundings of at most 2^-53 of each operation give (`rounded`), an
exponential within 2^-49 of its own.  V is the limit that the text aims at, the stated one less
2^-26: the speed stays within V (1 + 2^-28).
"""

from typing import Any

import casadi as ca

from wmr_ctrl.filter.channels import ROUNDING
from wmr_ctrl.filter.governor import FirstOrder, drive, largest_command, relaxed
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.command_filter import INTERVALS
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import (
    UNIT,
    Relation,
    Statement,
    above,
    at_least,
    symbols,
    within,
)

SLACK = 2.0**-28
"""Share of V by which the speed may be above its computed bound."""
LEAST = 2.0**-16
"""Least share of the way that the base goes in a period, 1 - exp(-T/tau_max)."""
LIBM = 2.0**-49
"""Largest relative error of a computed exponential, or of what is made of one."""
MARGIN = 32 * UNIT
NUMBERS = "V dbar nbar K_min K_max kappa"
NEAR = "w + 2^-28 V >= v, the speed; w, the computed bound, at most V"
claim = Claims(by=Z3(effort=100))


def _numbers(further: str, fixed: str = "") -> tuple[dict[str, ca.SX], FirstOrder]:
    s = symbols(f"{NUMBERS} {further}", f"{NUMBERS} {fixed}".strip())
    return s, FirstOrder(**{name: s[name] for name in NUMBERS.split()})


def _stated(b: FirstOrder) -> tuple[Relation, ...]:
    return above(b.K_min), at_least(b.K_max, b.K_min), at_least(b.dbar), above(b.V, b.dbar)


def _computed(value: ca.SX, exact: ca.SX) -> tuple[Relation, Relation]:
    return at_least(value, (1 - LIBM) * exact), at_least((1 + LIBM) * exact, value)


@claim(
    "filter.rounding.clip",
    given=f"{INTERVALS}; V the stated limit; operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def clip(mutation: Mutation) -> Statement:
    """K_max hi + dbar <= V for the hi that the clip's text computes, by a quotient or by 1/K_max.

    What the clip sends keeps the stated limit to the last bit.
    """
    s, b = _numbers("direct inverse")
    aimed = b.V * (1 - mutation(ROUNDING, -ROUNDING))
    top = largest_command(aimed, FirstOrder(aimed, b.dbar, b.nbar, b.K_min, b.K_max, ca.SX(0)))
    computed = {"direct": top, "inverse": (aimed - b.dbar) * (1 / b.K_max)}
    goals = tuple(at_least(b.V, b.K_max * s[name] + b.dbar) for name in computed)
    return Statement(s, goals, (*_stated(b), above(aimed, b.dbar)), computed=computed)


@claim(
    "filter.rounding.limit",
    given=f"{INTERVALS}; {NEAR}; mean <= K_max hi + dbar; e <= E <= 1, e = exp(-H/tau_min) <= 1 - "
    "2^-16, kappa within 2^-49 of e/(1 - e); operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def limit(mutation: Mutation) -> Statement:
    """E v + (1 - E) mean <= V (1 + 2^-28) for the hi that the governor's text computes.

    The computed limit keeps the speed even where its bound is too low by the rounding.
    """
    s, b = _numbers("w hi v E e mean")
    V, e, E = b.V, s["e"], s["E"]
    relaxing = above(e), at_least(1 - LEAST, e), at_least(E, e), at_least(ca.SX(1), E)
    ratio = b.kappa * (1 - e)
    given = (
        *_stated(b), *relaxing, *_computed(ratio, e), at_least(b.kappa),
        at_least(s["w"] + mutation(1, 64) * SLACK * V, s["v"]), at_least(V, s["w"]),
        at_least(s["w"], -V), at_least(b.K_max * s["hi"] + b.dbar, s["mean"]),
    )  # fmt: skip
    goal = at_least(V * (1 + SLACK), E * s["v"] + (1 - E) * s["mean"])
    return Statement(s, (goal,), given, computed={"hi": largest_command(s["w"], b)})


@claim(
    "filter.rounding.target",
    given=f"{INTERVALS}; operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def target(mutation: Mutation) -> Statement:
    """the computed drive(u) misses K u + dbar by at most 2^-51 (|drive(u) - dbar| + dbar).

    The speed towards which a command drives the base is computed well enough.
    """
    s, b = _numbers("u target")
    exact = drive(s["u"], b)
    most = mutation(4, 0.5) * UNIT * (ca.fabs(exact - b.dbar) + b.dbar)
    computed = {"target": exact}
    return Statement(s, within(s["target"] - exact, most), _stated(b), computed=computed)


@claim(
    "filter.rounding.relaxed",
    given="|w| <= 2 V, 0 <= share <= 2, |share (target - w)| <= 8 V; operations rounded by at "
    "most 2^-53",
    premises="assumption.libm",
)
def carried_on(mutation: Mutation) -> Statement:
    """the computed relaxed(w, target) misses w + share (target - w) by at most 2^-48 V.

    What is carried from sample to sample is computed well enough.
    """
    s = symbols("V w target share next", "V")
    V, way = s["V"], s["share"] * (s["target"] - s["w"])
    made = relaxed(s["w"], s["target"], s["share"], s["share"])
    given = (
        above(V), at_least(s["share"]), at_least(ca.SX(2), s["share"]), *within(s["w"], 2 * V),
        *within(way, 8 * V),
    )  # fmt: skip
    most = mutation(1, 2.0**-6) * MARGIN * V
    goals = within(s["next"] - (s["w"] + way), most)
    return Statement(s, goals, given, computed={"next": made})


WAYS: tuple[dict[str, Any], ...] = (
    {"word": "rising", "sign": 1, "told": "target >= w"},
    {"word": "falling", "sign": -1, "told": "target <= w"},
)


@claim(
    "filter.rounding.carried-{word}",
    given=f"{NEAR}; mean <= target + d, most d <= 2^-48 V, most |target| <= 6 V; 2^-16 <= least <= "
    "share <= most <= 1, the computed shares within 2^-49 of least and most; {told}",
    premises="filter.rounding.target filter.rounding.relaxed",
    over=WAYS,
)
def carried(mutation: Mutation, sign: int) -> Statement:
    """v + share (mean - v) <= relaxed(w, target) - 2^-48 V + 2^-28 V.

    The speed is above its computed bound by no more than it was a period before: errors fade.
    """
    s = symbols("V w v d target mean share most least most_as least_as", "V")
    V, most, share = s["V"], s["most"], s["share"]
    way = s["target"] - s["w"]
    following = relaxed(s["w"], s["target"], s["most_as"], s["least_as"])
    given = (
        above(V), at_least(s["least"], mutation(LEAST, 0.0)), at_least(most, s["least"]),
        at_least(ca.SX(1), most), *_computed(s["most_as"], most),
        *_computed(s["least_as"], s["least"]), at_least(share, s["least"]), at_least(most, share),
        at_least(s["w"] + SLACK * V, s["v"]), *within(s["w"], 2 * V), at_least(s["d"]),
        at_least(MARGIN * V, most * s["d"]), *within(most * s["target"], 6 * V),
        at_least(s["target"] + s["d"], s["mean"]), at_least(sign * way),
    )  # fmt: skip
    reached = s["v"] + share * (s["mean"] - s["v"])
    return Statement(s, (at_least(following - MARGIN * V + SLACK * V, reached),), given)


@claim(
    "filter.rounding.odometry",
    given="v <= y + nbar, |v| <= V (1 + 2^-28); operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def odometry(mutation: Mutation) -> Statement:
    """v <= min(y + nbar, V) + 2^-28 V, the sum as computed.

    A bound from odometry is too low by no more than a carried one.
    """
    s, b = _numbers("v y sum")
    V, slack = b.V, SLACK * b.V
    given = (above(V), at_least(b.nbar), *within(s["v"], V + slack))
    known = at_least(s["y"] + b.nbar, s["v"])
    goal = at_least(ca.fmin(s["sum"], V) + mutation(1, -1) * slack, s["v"])
    return Statement(s, (goal,), (*given, known), computed={"sum": s["y"] + b.nbar})


@claim(
    "filter.rounding.governor",
    given="the hypotheses of filter.induction, without delay, losses and jitter; v and omega by "
    "themselves; T >= 2^-15 tau_max; no overflow and no underflow",
    by=HAND,
    premises="filter.induction filter.rounding.limit filter.rounding.target "
    "filter.rounding.relaxed filter.rounding.carried-rising filter.rounding.carried-falling "
    "filter.rounding.odometry",
)
def governor() -> None:
    """|v| <= V (1 - 2^-26) (1 + 2^-28) (1 + 2^-52) < V, V the stated limit, behind what the text
    computes.

    The margin that is kept back covers the governor's roundings.
    """
