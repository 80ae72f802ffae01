"""The velocity guard behind drives with a delay, for any delay and any number of commands.

One sample of one axis, all parameters symbols.  That v reaches at most ``arrived`` is the
comparison lemma, used for each command under way; the rest is the lemma for the new one, and
induction (guard.delay.lemma).
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from wmr_ctrl.guard.guard import ceiling, clipped, floor
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.guard_late import LateAxis
from wmr_ctrl.proofs.claims.guard_queue import CAPS, COMMANDS, FEASIBLE, THEME, late_claim
from wmr_ctrl.proofs.finding import HAND
from wmr_ctrl.proofs.statement import Statement, above, at_least, symbols


def _caps(flip: float) -> Statement:
    a = LateAxis()
    b = a.bounds
    goals = (*a.capped, a.shared(1 if flip > 0 else 1.01))
    return Statement(a.symbols, goals, (*a.can_be_kept(), at_least(b.M_max)))


def _room(flip: float) -> Statement:
    a = LateAxis()
    b = a.bounds
    added = at_least(a["delay"] * (a.largest + a.net) / b.M_min, a["ahead"] + a["back"])
    goal = a.room(a.coming, 1 if flip > 0 else 0.99)
    return Statement(a.symbols, (goal,), (*a.sound(), *a.moving, a.shared(), added))


def _not_empty(flip: float) -> Statement:
    a = LateAxis()
    given = (*a.sound(), *a.capped, *a.moving, a.room(a.coming, 1 if flip > 0 else 1.01))
    return Statement(a.symbols, (at_least(a.hi, a.lo),), given, a.cuts)


def _largest(flip: float) -> Statement:
    a = LateAxis()
    most = (1 if flip > 0 else 0.99) * a.largest
    goals = (at_least(most, a.force), at_least(most, -a.force))
    return Statement(a.symbols, goals, (*a.sound(), *a.capped), a.cuts)


def _anchor(flip: float) -> Statement:
    a = LateAxis()
    b = a.bounds
    size = ca.fabs(clipped(ca.SX(0), a["y"], b, a.coming))
    most = (1 if flip > 0 else 0.99) * b.braking
    return Statement(a.symbols, (at_least(most, size),), (*a.sound(), *a.capped), a.cuts)


def _invariant(way: int) -> Callable[[float], Statement]:
    def statement(flip: float) -> Statement:
        a = LateAxis()
        b = a.bounds
        given = (
            *a.sound(1 if flip > 0 else 1.01), at_least(b.braking, a.net), *a.measured, *a.during,
            *a.moving, *a.arrives(way), at_least(a["u1"], a["arrived"]), at_least(a.hi, a.lo),
        )  # fmt: skip
        return Statement(a.symbols, (at_least(a["u1"], a.then(way)),), given, a.cuts)

    return statement


def _outside(flip: float) -> Statement:
    a = LateAxis()
    b, beyond = a.bounds, a["arrived"] - a["u1"]
    needed = ca.fmin(b.braking - a.net, (1 if flip > 0 else 1.01) * b.M_max * beyond / b.period)
    left = a.force + a.net
    given = (*a.sound(), *a.capped, *a.measured, *a.moving, *a.arrives(1), above(beyond))
    return Statement(a.symbols, (at_least(-left), at_least(-left, needed)), given, a.cuts)


def _return_step(flip: float) -> Statement:
    a = LateAxis()
    b, mass = a.bounds, a["mass"]
    step = b.period * (b.braking - a.net) / mass
    end = a["arrived"] + b.period * (a.force + a.net) / mass
    goal = at_least(ca.fmax(a["u1"], a["arrived"] - (1 if flip > 0 else 1.01) * step), end)
    beyond = above(a["arrived"], a["u1"])
    given = (*a.sound(), *a.capped, *a.measured, *a.during, *a.moving, *a.arrives(1), beyond)
    return Statement(a.symbols, (goal,), given, a.cuts)


def _graceful(flip: float) -> Statement:
    """|d| <= dbar + D: |v| <= u1 + D (T + delay)/M_min stays true."""
    a = LateAxis()
    b, D = a.bounds, a["extra"]
    late = D * a["delay"] / b.M_min
    limit = b.u1 + (1 if flip > 0 else 0.99) * D * (b.period + a["delay"]) / b.M_min
    given = (
        *a.sound(), *a.capped, *a.measured, *a.during, *a.moving, *a.arrives(1, late),
        at_least(D), at_least(b.braking - a.net, D), at_least(limit, a["arrived"]),
    )  # fmt: skip
    return Statement(a.symbols, (at_least(limit, a.then(1, D)),), given, a.cuts)


def _necessary(flip: float) -> Statement:
    """2 dbar (T + delay) > M_min u1: what holds u1 against +dbar can swing to -u1 after a stop."""
    t = symbols("u1 period delay M_min dbar force")
    held = at_least(ca.SX(0), t["force"] + t["dbar"])
    time = t["period"] + t["delay"]
    tight = above(2 * t["dbar"] * time, (1 if flip > 0 else 0.99) * t["M_min"] * t["u1"])
    positive = tuple(above(t[name]) for name in ("u1", "period", "M_min", "dbar", "delay"))
    swung = time * (t["dbar"] - t["force"]) / t["M_min"]
    return Statement(t, (above(swung, t["u1"]),), (*positive, tight, held))


def _longer(_: float) -> Statement:
    """The command under way acts 1 % longer than the guard counts: false."""
    a = LateAxis()
    b = a.bounds
    reached = ca.fmax(a["v"], b.f_speed) + a["since"] * ca.fmax(a["sent"] + a.net, 0) / a["mass"]
    force = clipped(a["asked"], a["y"], b, a.one)
    end = a["arrived"] + a["t"] * ca.fmax(force + a.net, 0) / a["mass"]
    time = 1.01 * a["periods"] * a["period"]
    given = (
        *a.sound(), *a.capped, *a.measured, *a.during, at_least(a["since"]), at_least(a["periods"]),
        at_least(time, a["since"]), at_least(reached, a["arrived"]),
        at_least(a["u1"], a["arrived"]), at_least(a["arrived"], b.f_speed),
        at_least(ceiling(a["y"], b, a.one), floor(a["y"], b, a.one)),
    )  # fmt: skip
    return Statement(a.symbols, (at_least(a["u1"], end),), given, a.cuts)


def _ignored(_: float) -> Statement:
    """A guard that counts nothing under way: false."""
    a = LateAxis()
    given = (
        *a.sound(), *a.capped, *a.measured, *a.during, *a.moving, *a.arrives(1),
        at_least(a["u1"], a["arrived"]), above(a["ahead"]),
    )  # fmt: skip
    force = clipped(a["asked"], a["y"], a.bounds)
    end = a["arrived"] + a["t"] * ca.fmax(force + a.net, 0) / a["mass"]
    return Statement(a.symbols, (at_least(a["u1"], end),), given, a.cuts)


def _uncapped(_: float) -> Statement:
    """One command under way that is as large as it may be without delay: lo <= hi is false."""
    a = LateAxis()
    b = a.bounds
    most = b.M_min * b.alpha * (b.u1 - b.f_speed) - a.net
    sent = (at_least(most, a["sent"]), at_least(most, -a["sent"]))
    whole = at_least(a["delay"], a["periods"] * a["period"])
    goal = at_least(ceiling(a["y"], b, a.one), floor(a["y"], b, a.one))
    given = (*a.can_be_kept(), *sent, whole, at_least(a["periods"]))
    return Statement(a.symbols, (goal,), given)


CLAIMS = (
    late_claim(
        "caps",
        "brakes = min(brake, cap): 0 <= brakes, net <= brakes <= largest, and delay (largest + net)"
        "/M_min + max(brakes + net, 0)/(M_min alpha) <= u1 - f_speed",
        "The delay takes its share of the room between rest and the limit, braking the rest.",
        FEASIBLE,
        _caps,
    ),
    *COMMANDS,
    late_claim(
        "room",
        "M_min alpha (u1 - f_speed - ahead - back) >= max(brakes + net, 0)",
        "What is under way never takes the room that braking needs.",
        "ahead + back <= delay (largest + net)/M_min, and the sum of guard.delay.caps",
        _room,
        ("guard.delay.caps", "guard.delay.command"),
    ),
    late_claim(
        "feasible",
        "lo(y) <= hi(y) for every y, whatever is under way",
        "There is always a safe force: nothing has to be checked while it runs.",
        f"{CAPS}, guard.delay.room, 2 nbar <= u1, alpha T <= 1",
        _not_empty,
        ("guard.delay.room",),
    ),
    late_claim(
        "largest",
        "|F| <= largest",
        "Commands stay as small as those before them were assumed to be.",
        CAPS,
        _largest,
        ("guard.delay.caps",),
    ),
    late_claim(
        "anchor",
        "|clip(0, lo, hi)| <= brakes",
        "The force of least effort is within the brake cap: the wheel maps keep the box.",
        CAPS,
        _anchor,
        ("guard.delay.caps",),
    ),
    late_claim(
        "upper",
        "v <= u1 where the new command starts to act: v <= u1 as long as it acts",
        "Inside stays inside, forwards.",
        f"|y - v| <= nbar, alpha T <= 1, {CAPS}, lo <= hi",
        _invariant(1),
        ("guard.delay.feasible",),
    ),
    late_claim(
        "lower",
        "the same for -v, whatever v is in the other direction",
        "Nor backwards, also while the robot is braked from outside.",
        f"|y - v| <= nbar, alpha T <= 1, {CAPS}, lo <= hi",
        _invariant(-1),
        ("guard.delay.feasible",),
    ),
    late_claim(
        "outside",
        "v > u1 where the new command starts to act: F + net <= -min(brakes - net, M_max (v - "
        "u1)/T)",
        "Outside the limit no disturbance can make the robot faster, once what was under way at "
        "the start is over.",
        f"|y - v| <= nbar; {CAPS}",
        _outside,
    ),
    late_claim(
        "return",
        "v > u1 where it starts to act: a sample later v <= max(u1, v - T (brakes - net)/M)",
        "Back inside after the delay and ceil((v - u1) M/(T (brakes - net))) samples, v being the "
        "speed after the delay and M at worst M_max.",
        f"|y - v| <= nbar, M_min <= M <= M_max; {CAPS}",
        _return_step,
    ),
    late_claim(
        "graceful",
        "|d| <= dbar + D keeps |v| <= u1 + D (T + delay)/M_min",
        "A bound that is broken by D costs a known excess, no more.",
        f"|y - v| <= nbar; brakes - net >= D; {CAPS}",
        _graceful,
    ),
    late_claim(
        "necessary",
        "2 dbar (T + delay) > M_min u1 and F + dbar <= 0: (T + delay) (dbar - F)/M_min > u1",
        "Beyond this bound no guard at all can keep the limit: friction may stop the robot just "
        "after a sample.",
        "u1, T, delay, M_min, dbar > 0",
        _necessary,
    ),
    late_claim(
        "longer",
        "guard.delay.upper, with a delay that is 1 % longer than stated",
        "False: the delay may be stated too long, not too short.",
        "one command under way",
        _longer,
    ),
    late_claim(
        "ignored",
        "guard.delay.upper, for the guard that knows of no delay",
        "False: what is under way has to be counted.",
        "ahead > 0",
        _ignored,
    ),
    late_claim(
        "uncapped",
        "guard.delay.feasible, with |F_j| <= M_min alpha (u1 - f_speed) - net",
        "False: without the smaller cap a state can be reached that has no safe force.",
        FEASIBLE,
        _uncapped,
    ),
    Claim(
        "guard.delay.lemma",
        (),
        OURS,
        "v+ = max(v, f_speed) is at most max(y + nbar, f_speed) + ahead when the new command "
        "starts to act; by induction over the samples |v| <= u1 at every instant from then on",
        "guard.lemma for one command under way after the other, then for the new one.",
        "the delay is constant and at most as stated, the commands before the first sample are 0, "
        "and max(|v|, f_speed) + delay max(net, 0)/M_min <= u1 at the start",
        verdict=HAND,
        premises=(
            "guard.lemma",
            "guard.delay.command",
            "guard.delay.command-angular",
            "guard.delay.queue",
            "guard.delay.upper",
            "guard.delay.lower",
        ),
        theme=THEME,
    ),
)
