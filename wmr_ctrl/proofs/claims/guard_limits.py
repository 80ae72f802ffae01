"""Optimality of the guard, necessity of its parts, and its theorems by hand.

Statements about one sample become statements about every instant of a run by the comparison lemma
(guard.lemma), used for each command under way and then for the new one, and by induction.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from wmr_ctrl.guard.delay import InFlight, waiting
from wmr_ctrl.guard.guard import ceiling, clipped, floor
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard import HARD, NUMBERS_FREE, upper
from wmr_ctrl.proofs.claims.guard_axis import AT_ONCE, DELAYED, LATE, GuardAxis
from wmr_ctrl.proofs.claims.guard_sent import FEASIBLE, only
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols

claim = Claims(by=Z3(effort=150))


@claim("guard.too-fast", given=f"{NUMBERS_FREE}, but alpha T <= 1.01")
def too_fast(mutation: Mutation) -> Statement:
    """guard.upper with alpha T up to 1.01.

    False: alpha = 1/T is the fastest approach to the limit that a held force admits.
    """
    return upper(-mutation, 1, GuardAxis(AT_ONCE))


@claim("guard.maximal", given="nbar = f_min = f_speed = 0, alpha = 1/T")
def maximal(mutation: Mutation) -> Statement:
    """0 <= v <= u1 and F > hi(v): v + T (F + dbar)/M_min > u1.

    No guard that intervenes less is safe.
    """
    a = GuardAxis()
    b = a.bounds
    exact = (b.nbar, b.f_min, b.f_speed, 1 - b.alpha * b.period)
    given = (*a.feasible(), *(equal(item) for item in exact), at_least(a["v"]), *a.inside)
    more = a["asked"] - ceiling(a["v"], b)
    end = a["v"] + b.period * (a["asked"] + b.dbar) / mutation(b.M_min, b.M_max)
    return Statement(a.symbols, (above(end, a["u1"]),), (*given, above(more)))


@claim(
    "guard.{at}necessary",
    given="u1, T, M_min, dbar{more} > 0",
    over=(
        {"at": "", "late": False, "T": "T", "more": "", "when": ""},
        {"at": "delay.", "late": True, "T": "(T + delay)", "more": ", delay",
         "when": " just after a sample"},
    ),
)  # fmt: skip
def necessary(mutation: Mutation, late: bool) -> Statement:
    """2 dbar {T} > M_min u1 and F + dbar <= 0: {T} (dbar - F)/M_min > u1.

    Beyond this bound no guard at all can keep the limit: friction of unknown size may stop the
    robot{when}.
    """
    t = symbols("u1 period M_min dbar delay force")
    u1, period, mass, dbar, delay, force = t.values()
    time = period + delay if late else period
    tight = above(2 * dbar * time, mutation(1, 0.99) * mass * u1)
    positive = [above(item) for item in (u1, period, mass, dbar, *([delay] * late))]
    goal = above(time * (dbar - force) / mass, u1)
    return Statement(t, (goal,), (*positive, tight, at_least(ca.SX(0), force + dbar)))


@claim("guard.delay.longer", given="one command under way")
def longer(_: Mutation) -> Statement:
    """guard.delay.upper, with a delay that is 1 % longer than stated.

    False: the delay may be stated too long, not too short.
    """
    a = GuardAxis(DELAYED)
    b = a.bounds
    reached = ca.fmax(a["v"], b.f_speed) + a["since"] * ca.fmax(a["sent"] + a.net, 0) / a["mass"]
    force = clipped(a["asked"], a["y"], b, only(a))
    end = a["arrived"] + a["t"] * ca.fmax(force + a.net, 0) / a["mass"]
    time = 1.01 * a["periods"] * a["period"]
    given = (
        *a.sound(), *a.capped, *a.measured, *a.during(), at_least(a["since"]),
        at_least(a["periods"]), at_least(time, a["since"]), at_least(reached, a["arrived"]),
        at_least(a["u1"], a["arrived"]), at_least(a["arrived"], b.f_speed),
        at_least(ceiling(a["y"], b, only(a)), floor(a["y"], b, only(a))),
    )  # fmt: skip
    return Statement(a.symbols, (at_least(a["u1"], end),), given, a.cuts)


@claim("guard.delay.ignored", given="ahead > 0")
def ignored(_: Mutation) -> Statement:
    """guard.delay.upper, for the guard that knows of no delay.

    False: what is under way has to be counted.
    """
    a = GuardAxis(DELAYED)
    given = (
        *a.stated, *a.seen(1, 0, *a.during()), at_least(a["u1"], a["arrived"]), above(a["ahead"]),
    )  # fmt: skip
    force = clipped(a["asked"], a["y"], a.bounds)
    end = a["arrived"] + a["t"] * ca.fmax(force + a.net, 0) / a["mass"]
    return Statement(a.symbols, (at_least(a["u1"], end),), given, a.cuts)


@claim("guard.delay.uncapped", given=FEASIBLE)
def uncapped(_: Mutation) -> Statement:
    """guard.delay.feasible, with |F_j| <= M_min alpha (u1 - f_speed) - net.

    False: without the smaller cap a state can be reached that has no safe force.
    """
    a = GuardAxis(DELAYED)
    b = a.bounds
    most = b.M_min * b.alpha * (b.u1 - b.f_speed) - a.net
    sent = (at_least(most, a["sent"]), at_least(most, -a["sent"]))
    whole = at_least(a["delay"], a["periods"] * a["period"])
    goal = at_least(ceiling(a["y"], b, only(a)), floor(a["y"], b, only(a)))
    return Statement(a.symbols, (goal,), (*a.feasible(), *sent, whole, at_least(a["periods"])))


@claim("guard.late.unmixed", given="0 < J <= T", by=HARD)
def unmixed(_: Mutation) -> Statement:
    """guard.late.upper, for the guard of a constant delay of the largest lateness.

    False: a command that takes over early and is replaced late acts for more than T.
    """
    a = GuardAxis(LATE)
    over, again = a.start(1), a.again
    coming = InFlight(a["ahead"] + again.ahead, a["back"] + again.back)
    force = clipped(a["asked"], a["y"], replace(a.bounds, jitter=None, mixed=None), coming)
    end = over + a["t"] * ca.fmax(force + a.net, 0) / a["mass"]
    exact = (equal(a.bounds.nbar), equal(a.bounds.f_speed), equal(a.bounds.f_min))
    sums = (equal(a["rest_ahead"], a["ahead"]), equal(a["rest_back"], a["back"]))
    given = (*a.stated, *a.seen(1), *exact, *sums, *a.during(), at_least(a["u1"], over))
    return Statement(a.symbols, (at_least(a["u1"], end),), given, a.cuts)


@claim("guard.varying.unvaried", given="0 < a < b", by=HARD)
def unvaried(_: Mutation) -> Statement:
    """guard.varying.steady.upper, for a guard that takes the lag for constant.

    False: a time constant that falls brings the new command sooner while what was sent is still
    felt.
    """
    a = GuardAxis(LATE, varies=False)
    t = symbols("z rise fast slow")
    b, z = a.bounds, t["z"]
    force = clipped(a["asked"], a["y"], b, InFlight(a["ahead"], a["back"]))
    p = ca.fmax(force + a.net, 0)
    end = a["arrived"] + waiting(z, p, b.period, t["rise"]) / b.M_min
    given = (
        *a.stated, *a.seen(1), at_least(z),
        equal(a["rest_ahead"], a["ahead"]), equal(a["rest_back"], a["back"]),
        above(t["fast"]), above(t["slow"], t["fast"]), above(t["rise"]),
        at_least(t["slow"] - t["fast"], t["rise"]), at_least(a["ahead"] * b.M_min, t["slow"] * z),
        at_least(b.u1, a["arrived"]),
    )  # fmt: skip
    return Statement({**a.symbols, **t}, (at_least(b.u1, end),), given, a.cuts)


@claim(
    "guard.lemma",
    given="F1 v >= f_min |v| above f_speed, F1 v >= 0 below, |d| <= dbar, F held",
    by=HAND,
)
def lemma() -> None:
    """v+ = max(v, f_speed) is absolutely continuous, and M dv+/dt <= F + dbar - f_min where v >
    f_speed, 0 elsewhere; so v+(t) <= v+(0) + t max(F + dbar - f_min, 0)/M_min.

    One inequality at the sample bounds the velocity at every instant up to the next.
    """


@claim(
    "guard.delay.lemma",
    given="the delay is constant and at most as stated, the commands before the first sample are "
    "0, and max(|v|, f_speed) + delay max(net, 0)/M_min <= u1 at the start",
    by=HAND,
    premises="guard.lemma guard.delay.command guard.delay.command-angular guard.delay.queue "
    "guard.delay.upper guard.delay.lower",
)
def delay_lemma() -> None:
    """v+ = max(v, f_speed) is at most max(y + nbar, f_speed) + ahead when the new command starts to
    act; by induction over the samples |v| <= u1 at every instant from then on.

    guard.lemma for one command under way after the other, then for the new one.
    """


@claim(
    "guard.late.mean",
    given="y is the mean of v over ages in [age, age + window] to within nbar",
    by=HAND,
    premises="guard.lemma guard.late.piece guard.late.rest",
)
def late_mean() -> None:
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
def late_lag() -> None:
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
def late_lemma() -> None:
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
def late_return() -> None:
    """Psi - u1 never grows while it is positive, and v+ - u1 is at most e at the latest a time lag
    + T (Psi - u1 - e)/e after t1, for 0 < e <= T (brakes - net)/M_max; without lag from then on.

    How soon a robot outside is back: at a steady pace down to what one sample of braking takes
    away, then by halves.
    """


@claim(
    "guard.varying.lag",
    given="drives of first order whose time constant lies in [a, b] and varies as it likes",
    by=HAND,
    premises="guard.lemma guard.varying.moved guard.varying.integral",
)
def varying_lag() -> None:
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
def varying_lemma() -> None:
    """|v| <= u1 at every instant from the first command on, by induction over the samples.

    The theorem for a lag that varies.
    """
