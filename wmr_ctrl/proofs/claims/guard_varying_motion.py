"""The guard behind a lag that varies: inside stays inside.

That the push felt stays below Z is by hand (guard.varying.lag), and so is the induction over the
samples (guard.varying.lemma).
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.guard.delay import InFlight, waiting
from wmr_ctrl.guard.guard import clipped
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard_latest import CAPS, LatestAxis, rooms_of
from wmr_ctrl.proofs.claims.guard_varying import EXPONENTIALS, VaryingAxis, twice
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols


def _lines(a: VaryingAxis, way: int, left: ca.SX, spare: ca.SX, more: float = 1) -> list[Relation]:
    """What is left, each line of it; ``spare`` is u1 less what is reached."""
    b = a.bounds
    z, after, again = (item / b.M_min for item in a.lasts(way))
    rise, late = a["rise"], a["rise_late"]
    return [
        at_least(spare - again, more * left),
        at_least(spare, (1 + b.alpha * a.J) * left),
        at_least(spare - again + rise * after, (1 + b.alpha * rise) * left),
        at_least(spare + late * z, (1 + b.alpha * (a.J + late)) * left),
    ]


def _fixed(a: VaryingAxis) -> tuple[Relation, ...]:
    """Without jitter T and T + J are the same time."""
    return () if a.varies else (equal(a["rise_late"], a["rise"]),)


claim = Claims(by=Z3(effort=400))


@twice(
    claim,
    "counts",
    given="reached as in guard.late.mean, with the integral of Z for the sums, and b Z; "
    f"{EXPONENTIALS}",
)
def counts(mutation: Mutation, varies: bool = True) -> Statement:
    """room is at most what each of its lines leaves of u1 less what is reached when the new command
    may first take over; either way.

    What the room is counted from.
    """
    a = VaryingAxis(varies=varies)
    b, goals = a.bounds, []
    for left, (way, name) in zip(rooms_of(a), ((1, "ahead"), (-1, "back")), strict=True):
        mean, rest = a[name], a[f"rest_{name}"]
        start = ca.fmax(ca.fmax(way * a["v"], b.f_speed) + mean, b.f_speed + rest)
        goals += _lines(a, way, left, b.u1 - mutation(1, 1.01) * start)
    given = (*a.sound(), *a.measured, *a.moving, *a.numbers, *_fixed(a))
    return Statement(a.symbols, tuple(goals), given)


@twice(
    claim,
    "upper",
    given="guard.varying.counts; M >= M_min, alpha T <= 1, lo <= hi, brakes >= net; "
    f"{EXPONENTIALS}",
    premises="guard.varying.feasible guard.varying.counts",
)
def upper(mutation: Mutation, varies: bool = True, way: int = 1) -> Statement:
    """p_0 > 0: what is reached + (T + J) p_0 + c(T + J) max(p_0 - Z, 0), and + what the last
    command adds in J + T p_0 + c(T) max(p_0 - Z_J, 0), over M_min, is at most u1.

    Inside stays inside, forwards: a larger push than the last is worst where it comes early, a
    smaller one where it comes late.
    """
    # A command of larger p than the last is worst early, another one late; both to their end.
    a = VaryingAxis(varies=varies)
    b, t = a.bounds, symbols("room_ahead room_back")
    left = t["room_ahead"] if way > 0 else t["room_back"]
    z, after, again = a.lasts(way)
    p = ca.fmax(way * a.force + a.net, 0)
    period = mutation(1, 1.01) * b.period
    early = waiting(z, p, period + a.J, a["rise_late"]) / a["mass"]
    late = (waiting(after, p, period, a["rise"]) + again) / a["mass"]
    goals = [
        at_least(b.u1, a["arrived"] + ca.if_else(p > 0, more, b.u1 - a["arrived"]))
        for more in (early, late)
    ]
    given = (
        *a.sound(), *a.numbers, *_fixed(a), at_least(b.braking, a.net), at_least(a.hi, a.lo),
        *_lines(a, way, left, b.u1 - a["arrived"]), at_least(z), at_least(after), at_least(again),
        at_least(a["mass"], b.M_min), above(b.M_min),
    )  # fmt: skip
    cuts = {**a.cuts, **dict(zip(t, rooms_of(a), strict=True))}
    return Statement({**a.symbols, **t}, tuple(goals), given, cuts)


@twice(
    claim,
    "lower",
    given="as guard.varying.upper",
    premises="guard.varying.feasible guard.varying.counts",
)
def lower(mutation: Mutation, varies: bool = True) -> Statement:
    """the same for -v, whatever v is in the other direction.

    Nor backwards.
    """
    return upper(mutation, varies, -1)


@twice(
    claim,
    "outside",
    given=f"guard.varying.counts; {CAPS}",
    premises="guard.varying.counts",
    back=True,
)
def outside(mutation: Mutation, varies: bool = True, way: int = 1) -> Statement:
    """what is reached > u1 where the new command takes over: F + net <= -min(brakes - net, M_max
    (it - u1)/T).

    Outside the limit no disturbance can make the robot faster, once what was sent before is over.
    """
    a = VaryingAxis(varies=varies)
    b, beyond = a.bounds, symbols("beyond")["beyond"]
    t = symbols("room_ahead room_back")
    again = a.lasts(way)[2] / b.M_min
    room = t["room_ahead"] if way > 0 else t["room_back"]
    needed = ca.fmin(b.braking - a.net, mutation(1, 1.01) * b.M_max * beyond / b.period)
    left = way * a.force + a.net
    given = (
        *a.sound(), *a.capped, above(beyond), at_least(a["arrived"] + again - b.u1, beyond),
        at_least(b.u1 - a["arrived"] - again, room), at_least(a.hi, a.lo),
    )  # fmt: skip
    cuts = {**a.cuts, **dict(zip(t, rooms_of(a), strict=True))}
    goals = (at_least(-left), at_least(-left, needed))
    return Statement({**a.symbols, **t, "beyond": beyond}, goals, given, cuts)


@twice(
    claim,
    "graceful",
    given="guard.varying.counts; F = hi; pushes and Z larger by at most D; p_0 + D > 0; brakes - "
    f"net >= D; {CAPS}",
    premises="guard.varying.counts",
    back=True,
)
def graceful(mutation: Mutation, varies: bool = True, way: int = 1) -> Statement:
    """|d| <= dbar + D: what is reached, with D for every time that counts, and what the last and
    the new command add, as in guard.varying.upper, is at most u1 + D (T + late)/M_min.

    A bound that is broken by D costs a known excess, no more.
    """
    # Pushes, and Z with them, are larger by at most D; worst for F = hi.
    a = VaryingAxis(varies=varies)
    b, D, t = a.bounds, a["extra"], symbols("room_ahead room_back")
    room = t["room_ahead"] if way > 0 else t["room_back"]
    z, after, again = a.lasts(way)
    p = ca.fmax((a.hi if way > 0 else -a.lo) + a.net + D, 0)
    early = waiting(z + D, p, b.period + a.J, a["rise_late"]) - D * a.J
    late = waiting(after + D, p, b.period, a["rise"]) + again
    limit = b.u1 + mutation(1, 0.99) * D * (b.period + a["delay"]) / b.M_min
    start = a["arrived"] + D * a["delay"] / b.M_min
    goals = [
        at_least(limit, ca.if_else(p > 0, start + more / b.M_min, b.u1)) for more in (early, late)
    ]
    given = (
        *a.sound(), *a.capped, *a.numbers, *_fixed(a), at_least(D), at_least(b.braking - a.net, D),
        *_lines(a, way, room, b.u1 - a["arrived"]), at_least(z), at_least(after),
        at_least(again),
    )  # fmt: skip
    cuts = {**a.cuts, **dict(zip(t, rooms_of(a), strict=True))}
    return Statement({**a.symbols, **t}, tuple(goals), given, cuts)


@claim("guard.varying.unvaried", given="0 < a < b")
def unvaried(_: Mutation) -> Statement:
    """guard.varying.steady.upper, for a guard that takes the lag for constant.

    False: a time constant that falls brings the new command sooner while what was sent is still
    felt.
    """
    a = LatestAxis(varies=False)
    t = symbols("z rise fast slow")
    b, z = a.bounds, t["z"]
    force = clipped(a["asked"], a["y"], b, InFlight(a["ahead"], a["back"]))
    p = ca.fmax(force + a.net, 0)
    end = a["arrived"] + waiting(z, p, b.period, t["rise"]) / b.M_min
    given = (
        *a.sound(), *a.capped, *a.measured, *a.moving, *a.begins(1), at_least(z),
        equal(a["rest_ahead"], a["ahead"]), equal(a["rest_back"], a["back"]),
        above(t["fast"]), above(t["slow"], t["fast"]), above(t["rise"]),
        at_least(t["slow"] - t["fast"], t["rise"]), at_least(a["ahead"] * b.M_min, t["slow"] * z),
        at_least(b.u1, a["arrived"]),
    )  # fmt: skip
    return Statement({**a.symbols, **t}, (at_least(b.u1, end),), given, a.cuts)


@claim(
    "guard.varying.lag",
    given="drives of first order whose time constant lies in [a, b] and varies as it likes",
    by=HAND,
    premises="guard.lemma guard.varying.moved guard.varying.integral",
)
def guard_varying_lag() -> None:
    """v+ at any later time is at most max(max(y + nbar, f_speed) + mean, f_speed + rest), each with
    the integral of Z from the ages in the window on; and less b Z of then, that + b Z.

    The push that is felt is at most Z, which rises with a and falls with b.
    """


@claim(
    "guard.varying.lemma",
    given="as guard.late.lemma, but for the lag",
    by=HAND,
    premises="guard.varying.lag guard.varying.piece guard.varying.upper guard.varying.lower "
    "guard.varying.feasible guard.late.largest",
)
def guard_varying_lemma() -> None:
    """|v| <= u1 at every instant from the first command on, by induction over the samples.

    The theorem for a lag that varies.
    """
