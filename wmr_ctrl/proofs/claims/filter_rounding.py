"""Rounding of the command filter: clips and governor as the compiled text computes them.

A computed number is whatever roundings of at most 2^-53 of each operation give (`rounded`), an
exponential within 2^-49 of its own.  V is the limit that the text aims at, the stated one less
2^-26: the speed stays within V (1 + 2^-28).
"""

from typing import Any

import casadi as ca

from wmr_ctrl.filter.channels import ROUNDING, Channel, scaled
from wmr_ctrl.filter.channels import WAYS as SIDES
from wmr_ctrl.filter.clip import moved, ramp_shares
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
LIBM = 2.0**-49
"""Largest relative error of a computed exponential, or of what is made of one."""
MARGIN = 32 * UNIT
OVER = 2.0**-29
"""Share of its limit by which rounding may carry a command that changes slowly beyond it."""
SLOWEST = 2.0**-20
"""Least change in a period of a command that changes slowly, as a share of its limit."""
PIECE = 2.0**-44
"""Share of V by which the speed may gain on its computed bound in a piece of time."""
A_PIECE = 2.0**-14
"""Least share of the way that the base goes while a command may act, for each piece of the time."""
NUMBERS = "V dbar nbar K_min K_max kappa"
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
    """K_max hi (1 + 2^-48) + dbar <= V for the hi that the clip's text computes, by a quotient or
    by 1/K_max.

    What the clip sends keeps the stated limit to the last bit.
    """
    s, b = _numbers("direct inverse")
    aimed = b.V * (1 - mutation(ROUNDING, -ROUNDING))
    top = largest_command(aimed, FirstOrder(aimed, b.dbar, b.nbar, b.K_min, b.K_max, ca.SX(0)))
    computed = {"direct": top, "inverse": (aimed - b.dbar) * (1 / b.K_max)}
    goals = tuple(at_least(b.V, b.K_max * s[name] * (1 + 2.0**-48) + b.dbar) for name in computed)
    return Statement(s, goals, (*_stated(b), above(aimed, b.dbar)), computed=computed)


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
    "filter.rounding.piece-{word}",
    given="w + e >= v, the speed; w, the computed bound; mean <= target + d, most d <= 2^-48 V, "
    "most |target| <= 6 V; 0 <= least <= share <= most <= 1, the computed shares within 2^-49 of "
    "least and most; {told}",
    premises="filter.rounding.target filter.rounding.rim filter.rounding.relaxed",
    over=WAYS,
)
def piece(mutation: Mutation, sign: int) -> Statement:
    """v + share (mean - v) <= relaxed(w, target) - 2^-48 V + (1 - least) e + 2^-44 V.

    However short a piece of time is, the speed gains on its computed bound by at most 2^-44 of V.
    """
    s = symbols("V w v d target mean share most least most_as least_as e", "V")
    V, e, most, share = s["V"], s["e"], s["most"], s["share"]
    following = relaxed(s["w"], s["target"], s["most_as"], s["least_as"])
    given = (
        above(V), at_least(s["least"]), at_least(most, s["least"]), at_least(ca.SX(1), most),
        *_computed(s["most_as"], most), *_computed(s["least_as"], s["least"]),
        at_least(share, s["least"]), at_least(most, share), at_least(e),
        at_least(s["w"] + e, s["v"]), *within(s["w"], 2 * V), at_least(s["d"]),
        at_least(MARGIN * V, most * s["d"]),
        *within(most * s["target"], 6 * V), at_least(s["target"] + s["d"], s["mean"]),
        at_least(sign * (s["target"] - s["w"])),
    )  # fmt: skip
    gained = (1 - s["least"]) * e + mutation(1, 2.0**-7) * PIECE * V
    reached = s["v"] + share * (s["mean"] - s["v"])
    return Statement(s, (at_least(following - MARGIN * V + gained, reached),), given)


@claim(
    "filter.rounding.takeover",
    given=f"{INTERVALS}; w + (2^-28 + 2 n 2^-44) V >= v, the speed; w, the computed bound, at most "
    "V; mean <= K_max hi + dbar + d, (1 - e) d <= 2^-47 V; 1 <= n; e = exp(-H/tau_min) <= 1 - n "
    "2^-14, kappa within 2^-49 of e/(1 - e); operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def takeover(mutation: Mutation) -> Statement:
    """e v + (1 - e) mean <= V (1 + 2^-28) for the hi that the governor's text computes.

    From a bound that was carried through n pieces of time, too, the computed limit keeps the speed.
    """
    s, b = _numbers("w hi v e d mean n")
    V, e, n = b.V, s["e"], s["n"]
    known = s["w"] + mutation(1, 64) * (SLACK + 2 * n * PIECE) * V
    given = (
        *_stated(b), above(e), at_least(1 - n * A_PIECE, e), at_least(n, ca.SX(1)),
        *_computed(b.kappa * (1 - e), e), at_least(b.kappa), at_least(known, s["v"]),
        at_least(V, s["w"]), at_least(s["w"], -V), at_least(s["d"]),
        at_least(2.0**-47 * V, (1 - e) * s["d"]),
        at_least(b.K_max * s["hi"] + b.dbar + s["d"], s["mean"]),
    )  # fmt: skip
    goal = at_least(V * (1 + SLACK), e * s["v"] + (1 - e) * s["mean"])
    return Statement(s, (goal,), given, computed={"hi": largest_command(s["w"], b)})


@claim(
    "filter.rounding.rim",
    given=f"{INTERVALS}; l > 0; operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def rim(mutation: Mutation) -> Statement:
    """the computed drive(v + l omega) misses its own by at most 2^-50 (K_max (|v| + l |omega|) +
    dbar).

    The speed towards which a command drives a wheel is computed well enough.
    """
    s, b = _numbers("v omega l target", "l")
    exact = drive(Channel((ca.SX(1), s["l"]), b, 1.0).of((s["v"], s["omega"])), b)
    size = ca.fabs(s["v"]) + s["l"] * ca.fabs(s["omega"])
    most = mutation(8, 0.4) * UNIT * (b.K_max * size + b.dbar)
    goals = within(s["target"] - exact, most)
    return Statement(s, goals, (*_stated(b), above(s["l"])), computed={"target": exact})


@claim(
    "filter.rounding.wheels",
    given="every command; l > 0; the wheels' limits lo < 0 < hi, of at most M in size; both axes "
    "scaled by one factor; operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def wheels(mutation: Mutation) -> Statement:
    """lo - 2^-49 M <= v + l omega, v - l omega <= hi + 2^-49 M, of the command that is computed.

    Wheels that are limited by themselves keep their limits, however v and l omega cancel.
    """
    s = symbols("r0 r1 l hi1 hi2 lo1 lo2 M v omega", "l")
    l, ones = s["l"], FirstOrder(*[ca.SX(1)] * 6)
    channels = [Channel((ca.SX(1), way * l), ones, 1.0) for way in SIDES]
    low, high = [s["lo1"], s["lo2"]], [s["hi1"], s["hi2"]]
    sent = scaled([s["r0"], s["r1"]], channels, low, high, "curvature")
    given, goals = [above(l)], list[Relation]()
    for least, most, way in zip(low, high, SIDES, strict=True):
        spare = mutation(1, 2.0**-6) * 2.0**-49 * s["M"]
        given += [above(most), above(-least), at_least(s["M"], most), at_least(s["M"], -least)]
        speed = s["v"] + way * l * s["omega"]
        goals += [at_least(most + spare, speed), at_least(speed, least - spare)]
    return Statement(s, tuple(goals), tuple(given), computed={"v": sent[0], "omega": sent[1]})


@claim(
    "filter.rounding.slew-limit",
    given="K > 0, delta, a, reach >= 0; V the stated limit; operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def slew_limit(mutation: Mutation) -> Statement:
    """K hi (1 + 2^-29) + delta + a (1 + 2^-30) reach <= V for the hi that the text of the clip of
    slow commands computes, by a quotient or by 1/K.

    The margin covers what rounding adds to commands and to how fast they change.
    """
    s = symbols("V K delta slew reach direct inverse", "V K delta slew reach")
    V, K, dbar = s["V"], s["K"], s["delta"] + s["slew"] * s["reach"]
    aimed = V * (1 - mutation(ROUNDING, -ROUNDING))
    top = largest_command(aimed, FirstOrder(aimed, dbar, ca.SX(0), K, K, ca.SX(0)))
    computed = {"direct": top, "inverse": (aimed - dbar) * (1 / K)}
    added = s["delta"] + s["slew"] * (1 + 2.0**-30) * s["reach"]
    goals = tuple(at_least(V, K * s[name] * (1 + OVER) + added) for name in computed)
    signs = above(K), at_least(s["delta"]), at_least(s["slew"]), at_least(s["reach"])
    return Statement(s, goals, (*signs, above(aimed, dbar)), computed=computed)


def _slow(s: dict[str, ca.SX]) -> tuple[Relation, ...]:
    """The command before is within its limit but for roundings, and the one that is wanted is."""
    hi = s["hi"]
    return (above(hi), *within(s["last"], hi * (1 + OVER)), *within(s["wanted"], hi))


@claim(
    "filter.rounding.slew-kept",
    given="|wanted| <= hi; the command before within hi (1 + 2^-29); 2^-22 <= share <= 1; "
    "operations rounded by at most 2^-53",
    premises="assumption.libm",
)
def slew_kept(mutation: Mutation) -> Statement:
    """|u| <= hi (1 + 2^-29), u as the text computes it.

    Rounding carries commands that change slowly no further beyond their limit with time.
    """
    s = symbols("hi last wanted share sent")
    shares = at_least(s["share"], mutation(2.0**-22, 0.0)), at_least(ca.SX(1), s["share"])
    goals = within(s["sent"], s["hi"] * (1 + OVER))
    computed = {"sent": moved(s["last"], s["wanted"], s["share"])}
    return Statement(s, goals, (*_slow(s), *shares), computed=computed)


@claim(
    "filter.rounding.slew-step",
    given="as in filter.rounding.slew-kept; a T >= 2^-20 hi; 0 <= share <= the axis' own share",
    premises="assumption.libm",
)
def slew_step(mutation: Mutation) -> Statement:
    """|u - u_before| <= a T (1 + 2^-30), the axis' own share >= 2^-22, as the text computes them.

    Commands change no faster than the clip of slow commands counts on.
    """
    s = symbols("hi last wanted share sent own slew T", "slew T")
    most = s["slew"] * s["T"]
    (own,) = ramp_shares(s["last"], s["wanted"], most)
    given = (
        *_slow(s), above(s["slew"]), above(s["T"]), at_least(s["share"]),
        at_least(most, mutation(1, 2.0**-10) * SLOWEST * s["hi"]), at_least(s["own"], s["share"]),
    )  # fmt: skip
    goals = (*within(s["sent"] - s["last"], most * (1 + 2.0**-30)), at_least(s["own"], 2.0**-22))
    computed = {"own": own, "sent": moved(s["last"], s["wanted"], s["share"])}
    return Statement(s, goals, given, computed=computed)


@claim(
    "filter.rounding.slew",
    given="the hypotheses of filter.slew; a T >= 2^-20 of the largest command, on both axes; no "
    "overflow and no underflow",
    by=HAND,
    premises="filter.slew filter.rounding.slew-limit filter.rounding.slew-kept "
    "filter.rounding.slew-step",
)
def slew() -> None:
    """|v| <= V, V the stated limit, behind what the text of the clip of slow commands computes.

    The margin that is kept back covers its roundings, for ever.
    """


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
    given="the hypotheses of filter.induction; v and omega by themselves, or the wheels, scaled by "
    "one factor; odometry of the sample; at most n pieces of time from a sample to the next, and "
    "to the latest takeover; T >= n 2^-13 tau_max; pieces as the schedule cuts them; no overflow "
    "and no underflow",
    by=HAND,
    premises="filter.induction filter.rounding.takeover filter.rounding.target filter.rounding.rim "
    "filter.rounding.relaxed filter.rounding.piece-rising filter.rounding.piece-falling "
    "filter.rounding.odometry filter.rounding.wheels",
)
def governor() -> None:
    """|v| <= V (1 - 2^-26) (1 + 2^-28) (1 + 2^-52) < V, V the stated limit, behind what the text
    computes: the speed is at most 2^-28 V + n 2^-44 V above its computed bound at samples, since
    the base goes at least n 2^-14 of its way in a period, and n 2^-44 V more at a takeover.

    The margin that is kept back covers the governor's roundings, with delays, losses and jitter.
    """
