"""The guard with late velocities, jitter and lag: inside stays inside, a broken bound has a price.

That the sums bound the motion is by hand (guard.late.mean and guard.late.lag), and so is the
induction over the samples (guard.late.lemma).
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from wmr_ctrl.guard.delay import InFlight, in_flight
from wmr_ctrl.guard.guard import clipped, room
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard_axis import LateAxis, both_ways
from wmr_ctrl.proofs.claims.guard_latest import CAPS, LatestAxis, rooms_of
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols

BEGINS = (
    "v+ when it may first take over <= max(max(m, f_speed) + mean, f_speed + rest), m the mean "
    "that was measured as y to within nbar (guard.late.mean)"
)
ACTS = "it takes over up to J later and acts up to T + J - that, M_min <= M <= M_max"


claim = Claims(by=Z3(effort=400))


@claim(
    "guard.late.upper",
    given=f"guard.late.left; {ACTS}; alpha T <= 1, {CAPS}, lo <= hi",
    premises="guard.late.feasible guard.late.left",
)
def guard_late_upper(mutation: Mutation, way: int = 1, varies: bool = True) -> Statement:
    """v+ <= u1 where the new command takes over: v+ <= u1 as long as it acts.

    Inside stays inside, forwards.
    """
    a = LatestAxis(varies=varies)
    b = a.bounds
    t = symbols("room_ahead room_back")
    left = t["room_ahead"] if way > 0 else t["room_back"]
    again = a.again.ahead if way > 0 else a.again.back
    over = a.takes_over(way)
    end = over + a["t"] * ca.fmax(way * a.force + a.net, 0) / a["mass"]
    given = (
        *a.sound(), at_least(b.braking, a.net), *a.acts(mutation(1, 1.01)),
        at_least(a["arrived"], b.f_speed), at_least(b.u1 - a["arrived"], left + again),
        at_least(b.u1 - a["arrived"], (1 + b.alpha * a.J) * left),
        at_least(a["u1"], over), at_least(a.hi, a.lo),
    )  # fmt: skip
    cuts = {**a.cuts, **dict(zip(t, rooms_of(a), strict=True))}
    return Statement({**a.symbols, **t}, (at_least(a["u1"], end),), given, cuts)


@claim(
    "guard.late.lower",
    given=f"guard.late.left; {ACTS}; alpha T <= 1, {CAPS}, lo <= hi",
    premises="guard.late.feasible guard.late.left",
)
def guard_late_lower(mutation: Mutation) -> Statement:
    """the same for -v, whatever v is in the other direction.

    Nor backwards.
    """
    return guard_late_upper(mutation, -1)


@both_ways(
    claim, "guard.late.outside", given=f"{BEGINS}; {CAPS}", back="; lo <= hi (guard.late.feasible)"
)
def guard_late_outside(mutation: Mutation, varies: bool = True, way: int = 1) -> Statement:
    """v+ > u1 where the new command takes over: F + net <= -min(brakes - net, M_max (v+ - u1)/T).

    Outside the limit no disturbance can make the robot faster, once what was sent before is over.
    """
    a = LatestAxis(varies=varies)
    b, over = a.bounds, a.takes_over(way)
    beyond = over - a["u1"]
    needed = ca.fmin(b.braking - a.net, mutation(1, 1.01) * b.M_max * beyond / b.period)
    left = way * a.force + a.net
    given = (
        *a.sound(), *a.capped, *a.measured, *a.moving, *a.begins(way), *a.acts(), above(beyond),
        *a.not_empty(way),
    )  # fmt: skip
    return Statement(a.symbols, (at_least(-left), at_least(-left, needed)), given, a.cuts)


@claim("guard.late.left", given=BEGINS)
def guard_late_left(mutation: Mutation, varies: bool = True) -> Statement:
    """room + J max(F_1 + net, 0)/M_min and (1 + alpha J) room are at most u1 less v+ when the new
    command may first take over.

    What the room is counted from; the same for -v.
    """
    a = LatestAxis(varies=varies)
    b, rooms, goals = a.bounds, rooms_of(a), []
    ways = ((1, "ahead", a.again.ahead), (-1, "back", a.again.back))
    for left, (way, name, again) in zip(rooms, ways, strict=True):
        mean, rest = a[name], a[f"rest_{name}"]
        start = ca.fmax(ca.fmax(way * a["v"], b.f_speed) + mean, b.f_speed + rest)
        most = b.u1 - mutation(1, 1.01) * start
        goals += [at_least(most, left + again), at_least(most, (1 + b.alpha * a.J) * left)]
    return Statement(a.symbols, tuple(goals), (*a.sound(), *a.measured, *a.moving))


@both_ways(
    claim,
    "guard.late.graceful",
    given=f"guard.late.left with D (late - J)/M_min more; {ACTS}, to the end of that; brakes - "
    f"net >= D; {CAPS}",
    premises="guard.late.left",
)
def guard_late_graceful(mutation: Mutation, varies: bool = True, way: int = 1) -> Statement:
    """|d| <= dbar + D keeps v+ <= u1 + D (T + late)/M_min.

    A bound that is broken by D costs a known excess, no more.
    """
    a = LatestAxis(varies=varies)  # t at its end, as v is linear
    b, D = a.bounds, a["extra"]
    early = D * (a["delay"] - a.J) / b.M_min
    limit = b.u1 + mutation(1, 0.99) * D * (b.period + a["delay"]) / b.M_min
    most, again, coming = a.hi, a.again.ahead, a.coming
    if way < 0:
        most, again, coming = -a.lo, a.again.back, a.coming.mirrored
    t = symbols("room")
    over = a.takes_over(way, D)
    last = b.period + a.J - a["since"]
    end = over + last * ca.fmax(most + a.net + D, 0) / a["mass"]
    free = a["arrived"] - early - b.u1
    given = (
        *a.sound(), *a.capped, *a.acts(), at_least(a["arrived"], b.f_speed),
        at_least(-free, t["room"] + again),
        at_least(-free, (1 + b.alpha * a.J) * t["room"]),
        at_least(D), at_least(b.braking - a.net, D), at_least(limit, over),
    )  # fmt: skip
    cuts = {**a.cuts, "room": room(way * a["y"], b, coming)}
    return Statement({**a.symbols, **t}, (at_least(limit, end),), given, cuts)


@claim("guard.late.rest", given="one command in the window; before, v = -V")
def guard_late_rest(mutation: Mutation, counts_rest: bool = True) -> Statement:
    """v = share window p/M_min, after friction has stopped the robot with a share of the window
    left, is at most what the guard counts from the mean, or from rest over the window.

    Why the guard counts from the oldest instant, too.
    """
    a = LateAxis()
    b, t = a.bounds, symbols("V share window")
    p, window, share = ca.fmax(a["sent"] + a.net, 0), t["window"], t["share"]
    v = share * window * p / b.M_min
    y = share * v / 2 - (1 - share) * t["V"]
    pair, periods = ca.vertcat(a["sent"], 0), window / b.period
    mean, rest = (in_flight([(pair, part * periods)], 0, b) for part in (0.5, 1.0))
    coming = InFlight(mean.ahead, mean.back, rest if counts_rest else None)
    reached = coming.reached(ca.fmax(y + b.nbar, b.f_speed), b)
    given = (
        *a.sound(), above(window), at_least(share), at_least(1, share), at_least(t["V"]),
        at_least(b.u1, t["V"]),
    )  # fmt: skip
    return Statement({**a.symbols, **t}, (at_least(reached, mutation(1, 1.01) * v),), given)


@claim("guard.late.half", given="one command in the window; before, v = -V")
def guard_late_half(mutation: Mutation) -> Statement:
    """the same, counted from the mean alone.

    False: half the window is not enough, since friction can stop the robot inside it.
    """
    return guard_late_rest(mutation, False)


@claim("guard.late.unmixed", given="0 < J <= T")
def unmixed(_: Mutation) -> Statement:
    """guard.late.upper, for the guard of a constant delay of the largest lateness.

    False: a command that takes over early and is replaced late acts for more than T.
    """
    a = LatestAxis()
    over = a.takes_over(1)
    coming = InFlight(a["ahead"] + a.again.ahead, a["back"] + a.again.back)
    force = clipped(a["asked"], a["y"], replace(a.bounds, jitter=None, mixed=None), coming)
    end = over + a["t"] * ca.fmax(force + a.net, 0) / a["mass"]
    exact = (equal(a.bounds.nbar), equal(a.bounds.f_speed), equal(a.bounds.f_min))
    equal_sums = (equal(a["rest_ahead"], a["ahead"]), equal(a["rest_back"], a["back"]))
    given = (
        *a.sound(), *a.capped, *a.measured, *a.moving, *exact, *equal_sums, *a.begins(1), *a.acts(),
        at_least(a["u1"], over),
    )  # fmt: skip
    return Statement(a.symbols, (at_least(a["u1"], end),), given, a.cuts)


@claim(
    "guard.late.steady.upper",
    given=f"guard.late.steady.left; alpha T <= 1, {CAPS}, lo <= hi",
    premises="guard.late.steady.feasible guard.late.steady.left",
)
def guard_late_steady_upper(mutation: Mutation) -> Statement:
    """guard.late.upper for a delay that does not vary.

    Inside stays inside, forwards, without jitter.
    """
    return guard_late_upper(mutation, 1, False)


@claim(
    "guard.late.steady.lower",
    given=f"guard.late.steady.left; alpha T <= 1, {CAPS}, lo <= hi",
    premises="guard.late.steady.feasible guard.late.steady.left",
)
def guard_late_steady_lower(mutation: Mutation) -> Statement:
    """guard.late.lower for a delay that does not vary.

    Nor backwards.
    """
    return guard_late_upper(mutation, -1, False)


@both_ways(
    claim,
    "guard.late.steady.outside",
    given=f"{BEGINS}; {CAPS}",
    back="; lo <= hi (guard.late.feasible)",
)
def guard_late_steady_outside(mutation: Mutation, way: int = 1) -> Statement:
    """guard.late.outside for a delay that does not vary.

    Outside the limit no disturbance can make the robot faster, without jitter.
    """
    return guard_late_outside(mutation, False, way)


@claim("guard.late.steady.left", given=BEGINS)
def guard_late_steady_left(mutation: Mutation) -> Statement:
    """room is at most u1 less v+ when the new command takes over.

    guard.late.left for a delay that does not vary, either way.
    """
    return guard_late_left(mutation, False)


@both_ways(
    claim,
    "guard.late.steady.graceful",
    given="guard.late.steady.left with D late/M_min more; to the end of T; brakes - net >= D; "
    f"{CAPS}",
    premises="guard.late.steady.left",
)
def guard_late_steady_graceful(mutation: Mutation, way: int = 1) -> Statement:
    """guard.late.graceful for a delay that does not vary.

    A bound that is broken by D costs a known excess, without jitter.
    """
    return guard_late_graceful(mutation, False, way)


@both_ways(
    claim,
    "guard.late.steady.return",
    given=f"{BEGINS}; M_min <= M <= M_max; {CAPS}",
    back="; lo <= hi (guard.late.feasible)",
)
def returns(mutation: Mutation, way: int = 1) -> Statement:
    """v > u1 where the new command takes over, neither jitter nor lag: a sample later v <= max(u1,
    v - T (brakes - net)/M).

    Late and averaged velocities change nothing about how soon the robot is back.
    """
    a = LatestAxis(varies=False)
    b, mass, start = a.bounds, a["mass"], a["arrived"]
    step = b.period * (b.braking - a.net) / mass
    end = start + b.period * (way * a.force + a.net) / mass
    goal = at_least(ca.fmax(a["u1"], start - mutation(1, 1.01) * step), end)
    given = (
        *a.sound(), *a.capped, *a.measured, *a.during, *a.moving, *a.begins(way),
        above(start, a["u1"]), *a.not_empty(way),
    )  # fmt: skip
    return Statement(a.symbols, (goal,), given, a.cuts)


@claim(
    "guard.late.mean",
    given="y is the mean of v over ages in [age, age + window] to within nbar",
    by=HAND,
    premises="guard.lemma guard.late.piece guard.late.rest",
)
def guard_late_mean() -> None:
    """v+ now is at most max(y + nbar + sum of mean pieces, f_speed + sum of rest pieces).

    guard.lemma from every age in the window, averaged; or from where the robot last stood.
    """


@claim(
    "guard.late.lag",
    given="drives with a step response S that rises from 0 to 1 and is at least 1 - exp(-s/b), "
    "the same for both wheels and all the time: a first order with any constant time constant up "
    "to b",
    by=HAND,
    premises="guard.lemma",
)
def guard_late_lag() -> None:
    """Psi = v+ + (1/M_min) times the integral over the past of (1 - S(s)) max(F(-s) + net, 0) rises
    by at most max(F + net, 0)/M_min, and v+ <= Psi.

    Behind drives with a lag everything is said of Psi, with 1 - S(s) <= exp(-s/b).
    """


@claim(
    "guard.late.lemma",
    given="commands take over in their order, both wheels at once, each between delay - J and "
    "delay after its sample, J <= T; before the first sample the robot stood, or its velocity is "
    "measured at once, and commands were 0; max(|v|, f_speed) + (delay + lag) max(net, 0)/M_min "
    "<= u1 at the start",
    by=HAND,
    premises="guard.late.mean guard.late.lag guard.late.piece guard.late.tail guard.late.upper "
    "guard.late.lower guard.late.feasible guard.late.largest",
)
def guard_late_lemma() -> None:
    """|v| <= u1 at every instant from the first command on, by induction over the samples.

    The theorem for late velocities, jitter and lag.
    """


@claim(
    "guard.late.return",
    given="the bounds hold from some t0 on; Psi is that of t1, the instant from which on only "
    "commands act whose sample's window lies behind t0; brakes > net; M_min <= M <= M_max",
    by=HAND,
    premises="guard.late.outside guard.late.upper guard.late.lag guard.varying.outside",
)
def guard_late_return() -> None:
    """Psi - u1 never grows while it is positive, and v+ - u1 is at most e at the latest a time lag
    + T (Psi - u1 - e)/e after t1, for 0 < e <= T (brakes - net)/M_max; without lag from then on.

    How soon a robot outside is back: at a steady pace down to what one sample of braking takes
    away, then by halves.
    """
