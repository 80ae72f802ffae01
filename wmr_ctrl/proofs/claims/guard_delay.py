"""The velocity guard behind drives with a delay, for any delay and any number of commands.

One sample of one axis, all parameters symbols.  That v reaches at most ``arrived`` is the
comparison lemma, used for each command under way; the rest is the lemma for the new one, and
induction (guard.delay.lemma).
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.guard.delay import in_flight
from wmr_ctrl.guard.guard import ceiling, clipped, floor
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard_axis import LateAxis, both_ways
from wmr_ctrl.proofs.ledger import HAND
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, column, equal, symbols

FEASIBLE = (
    "2 net (1 + alpha delay) <= M_min alpha (u1 - f_speed), net = dbar - f_min, 2 nbar <= u1, "
    "brake >= net, alpha T <= 1; every other number free"
)
CAPS = "0 <= brakes, net <= brakes <= largest (guard.delay.caps)"


NOT_EMPTY = "; lo <= hi (guard.delay.feasible)"
claim = Claims(by=Z3(effort=150))


@claim("guard.delay.caps", given=FEASIBLE)
def caps(mutation: Mutation) -> Statement:
    """brakes = min(brake, cap): 0 <= brakes, net <= brakes <= largest, and delay (largest +
    net)/M_min + max(brakes + net, 0)/(M_min alpha) <= u1 - f_speed.

    The delay takes its share of the room between rest and the limit, braking the rest.
    """
    a = LateAxis()
    b = a.bounds
    goals = (*a.capped, a.shared(mutation(1, 1.01)))
    return Statement(a.symbols, goals, (*a.can_be_kept(), at_least(b.M_max)))


@claim(
    "guard.delay.command",
    given=f"one command; |F_j| <= largest, |y - v| <= nbar, M_min <= M <= M_max; {CAPS}",
)
def guard_delay_command(mutation: Mutation, axis: int = 0) -> Statement:
    """max(F_j + net, 0) + max(net - F_j, 0) <= largest + net for a single command under way, and v
    and -v at most the guard's count as long as it acts; first axis.

    What a command on its way can do is what the guard counts, also if it acts for a shorter time.
    """
    a = LateAxis(axis)
    b, time = a.bounds, a["periods"] * a["period"]
    most = mutation(1, 0.99) * time * (a.largest + a.net) / b.M_min
    goals = [at_least(most, a.one.ahead + a.one.back)]
    for way, coming in ((1, a.one.ahead), (-1, a.one.back)):
        start = ca.fmax(way * a["v"], b.f_speed)
        seen = ca.fmax(way * a["y"] + b.nbar, b.f_speed)
        reached = start + a["since"] * ca.fmax(way * a["sent"] + a.net, 0) / a["mass"]
        goals.append(at_least(seen + coming, reached))
    sent = (at_least(a.largest, a["sent"]), at_least(a.largest, -a["sent"]))
    during = (at_least(a["since"]), at_least(time, a["since"]), at_least(a["periods"]))
    given = (*a.sound(), *a.capped, *a.measured, *a.during, *sent, *during)
    return Statement(a.symbols, tuple(goals), given)


@claim(
    "guard.delay.command-angular",
    given=f"one command; |F_j| <= largest, |y - v| <= nbar, M_min <= M <= M_max; {CAPS}",
)
def guard_delay_command_angular(mutation: Mutation) -> Statement:
    """the same on the second axis, whatever the first axis is sent.

    The guard counts each axis's own force.
    """
    return guard_delay_command(mutation, 1)


@claim("guard.delay.queue", given="any forces and times")
def queue(mutation: Mutation) -> Statement:
    """n commands under way add up: their sums ahead and back are those of n - 1 and of the last
    one, both axes, n = 1 to 5.

    Whatever is shown of one command and of a sum holds for the commands together.
    """
    a = LateAxis()
    t = {**column("F", 5), **column("N", 5), **column("time", 5)}
    sent = [(ca.vertcat(t[f"F{j}"], t[f"N{j}"]), t[f"time{j}"]) for j in range(1, 6)]
    goals = []
    for axis in (0, 1):
        for n in range(1, 6):
            every, last = (in_flight(part, axis, a.bounds) for part in (sent[:n], sent[n - 1 : n]))
            rest = in_flight(sent[: n - 1], axis, a.bounds)
            goals.append(equal(every.ahead, rest.ahead + mutation * last.ahead))
            goals.append(equal(every.back, rest.back + last.back))
    return Statement({**a.symbols, **t}, tuple(goals), (above(a.bounds.M_min),))


@claim(
    "guard.delay.room",
    given="ahead + back <= delay (largest + net)/M_min, and the sum of guard.delay.caps",
    premises="guard.delay.caps guard.delay.command",
)
def room(mutation: Mutation) -> Statement:
    """M_min alpha (u1 - f_speed - ahead - back) >= max(brakes + net, 0).

    What is under way never takes the room that braking needs.
    """
    a = LateAxis()
    b = a.bounds
    added = at_least(a["delay"] * (a.largest + a.net) / b.M_min, a["ahead"] + a["back"])
    goal = a.room(a.coming, mutation(1, 0.99))
    return Statement(a.symbols, (goal,), (*a.sound(), *a.moving, a.shared(), added))


@claim(
    "guard.delay.feasible",
    given=f"{CAPS}, guard.delay.room, 2 nbar <= u1, alpha T <= 1",
    premises="guard.delay.room",
)
def not_empty(mutation: Mutation) -> Statement:
    """lo(y) <= hi(y) for every y, whatever is under way.

    There is always a safe force: nothing has to be checked while it runs.
    """
    a = LateAxis()
    given = (*a.sound(), *a.capped, *a.moving, a.room(a.coming, mutation(1, 1.01)))
    return Statement(a.symbols, (at_least(a.hi, a.lo),), given, a.cuts)


@claim("guard.delay.largest", given=CAPS, premises="guard.delay.caps")
def largest(mutation: Mutation) -> Statement:
    """|F| <= largest.

    Commands stay as small as those before them were assumed to be.
    """
    a = LateAxis()
    most = mutation(1, 0.99) * a.largest
    goals = (at_least(most, a.force), at_least(most, -a.force))
    return Statement(a.symbols, goals, (*a.sound(), *a.capped), a.cuts)


@claim("guard.delay.anchor", given=CAPS, premises="guard.delay.caps")
def anchor(mutation: Mutation) -> Statement:
    """|clip(0, lo, hi)| <= brakes.

    The force of least effort is within the brake cap: the wheel maps keep the box.
    """
    a = LateAxis()
    b = a.bounds
    size = ca.fabs(clipped(ca.SX(0), a["y"], b, a.coming))
    most = mutation(1, 0.99) * b.braking
    return Statement(a.symbols, (at_least(most, size),), (*a.sound(), *a.capped), a.cuts)


@claim(
    "guard.delay.upper",
    given=f"|y - v| <= nbar, alpha T <= 1, {CAPS}, lo <= hi",
    premises="guard.delay.feasible",
)
def guard_delay_upper(mutation: Mutation, way: int = 1) -> Statement:
    """v <= u1 where the new command starts to act: v <= u1 as long as it acts.

    Inside stays inside, forwards.
    """
    a = LateAxis()
    b = a.bounds
    given = (
        *a.sound(mutation(1, 1.01)), at_least(b.braking, a.net), *a.measured, *a.during,
        *a.moving, *a.arrives(way), at_least(a["u1"], a["arrived"]), at_least(a.hi, a.lo),
    )  # fmt: skip
    return Statement(a.symbols, (at_least(a["u1"], a.then(way)),), given, a.cuts)


@claim(
    "guard.delay.lower",
    given=f"|y - v| <= nbar, alpha T <= 1, {CAPS}, lo <= hi",
    premises="guard.delay.feasible",
)
def guard_delay_lower(mutation: Mutation) -> Statement:
    """the same for -v, whatever v is in the other direction.

    Nor backwards, also while the robot is braked from outside.
    """
    return guard_delay_upper(mutation, -1)


@both_ways(claim, "guard.delay.outside", given=f"|y - v| <= nbar; {CAPS}", back=NOT_EMPTY)
def outside(mutation: Mutation, way: int = 1) -> Statement:
    """v > u1 where the new command starts to act: F + net <= -min(brakes - net, M_max (v - u1)/T).

    Outside the limit no disturbance can make the robot faster, once what was under way at the start
    is over.
    """
    a = LateAxis()
    b, beyond = a.bounds, a["arrived"] - a["u1"]
    needed = ca.fmin(b.braking - a.net, mutation(1, 1.01) * b.M_max * beyond / b.period)
    left = way * a.force + a.net
    given = (
        *a.sound(),
        *a.capped,
        *a.measured,
        *a.moving,
        *a.arrives(way),
        above(beyond),
        *a.not_empty(way),
    )
    return Statement(a.symbols, (at_least(-left), at_least(-left, needed)), given, a.cuts)


@both_ways(
    claim,
    "guard.delay.return",
    given=f"|y - v| <= nbar, M_min <= M <= M_max; {CAPS}",
    back=NOT_EMPTY,
)
def return_step(mutation: Mutation, way: int = 1) -> Statement:
    """v > u1 where it starts to act: a sample later v <= max(u1, v - T (brakes - net)/M).

    Back inside after the delay and ceil((v - u1) M/(T (brakes - net))) samples, v being the speed
    after the delay and M at worst M_max.
    """
    a = LateAxis()
    b, mass = a.bounds, a["mass"]
    step = b.period * (b.braking - a.net) / mass
    end = a["arrived"] + b.period * (way * a.force + a.net) / mass
    goal = at_least(ca.fmax(a["u1"], a["arrived"] - mutation(1, 1.01) * step), end)
    beyond = above(a["arrived"], a["u1"])
    given = (
        *a.sound(),
        *a.capped,
        *a.measured,
        *a.during,
        *a.moving,
        *a.arrives(way),
        beyond,
        *a.not_empty(way),
    )
    return Statement(a.symbols, (goal,), given, a.cuts)


@both_ways(
    claim,
    "guard.delay.graceful",
    given=f"|y - v| <= nbar; brakes - net >= D; {CAPS}",
    back=NOT_EMPTY,
)
def graceful(mutation: Mutation, way: int = 1) -> Statement:
    """|d| <= dbar + D keeps |v| <= u1 + D (T + delay)/M_min.

    A bound that is broken by D costs a known excess, no more.
    """
    a = LateAxis()
    b, D = a.bounds, a["extra"]
    late = D * a["delay"] / b.M_min
    limit = b.u1 + mutation(1, 0.99) * D * (b.period + a["delay"]) / b.M_min
    given = (
        *a.sound(), *a.capped, *a.measured, *a.during, *a.moving, *a.arrives(way, late),
        at_least(D), at_least(b.braking - a.net, D), at_least(limit, a["arrived"]),
        *a.not_empty(way),
    )  # fmt: skip
    return Statement(a.symbols, (at_least(limit, a.then(way, D)),), given, a.cuts)


@claim("guard.delay.necessary", given="u1, T, delay, M_min, dbar > 0")
def necessary(mutation: Mutation) -> Statement:
    """2 dbar (T + delay) > M_min u1 and F + dbar <= 0: (T + delay) (dbar - F)/M_min > u1.

    Beyond this bound no guard at all can keep the limit: friction may stop the robot just after a
    sample.
    """
    t = symbols("u1 period delay M_min dbar force")
    held = at_least(ca.SX(0), t["force"] + t["dbar"])
    time = t["period"] + t["delay"]
    tight = above(2 * t["dbar"] * time, mutation(1, 0.99) * t["M_min"] * t["u1"])
    positive = tuple(above(t[name]) for name in ("u1", "period", "M_min", "dbar", "delay"))
    swung = time * (t["dbar"] - t["force"]) / t["M_min"]
    return Statement(t, (above(swung, t["u1"]),), (*positive, tight, held))


@claim("guard.delay.longer", given="one command under way")
def longer(_: Mutation) -> Statement:
    """guard.delay.upper, with a delay that is 1 % longer than stated.

    False: the delay may be stated too long, not too short.
    """
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


@claim("guard.delay.ignored", given="ahead > 0")
def ignored(_: Mutation) -> Statement:
    """guard.delay.upper, for the guard that knows of no delay.

    False: what is under way has to be counted.
    """
    a = LateAxis()
    given = (
        *a.sound(), *a.capped, *a.measured, *a.during, *a.moving, *a.arrives(1),
        at_least(a["u1"], a["arrived"]), above(a["ahead"]),
    )  # fmt: skip
    force = clipped(a["asked"], a["y"], a.bounds)
    end = a["arrived"] + a["t"] * ca.fmax(force + a.net, 0) / a["mass"]
    return Statement(a.symbols, (at_least(a["u1"], end),), given, a.cuts)


@claim("guard.delay.uncapped", given=FEASIBLE)
def uncapped(_: Mutation) -> Statement:
    """guard.delay.feasible, with |F_j| <= M_min alpha (u1 - f_speed) - net.

    False: without the smaller cap a state can be reached that has no safe force.
    """
    a = LateAxis()
    b = a.bounds
    most = b.M_min * b.alpha * (b.u1 - b.f_speed) - a.net
    sent = (at_least(most, a["sent"]), at_least(most, -a["sent"]))
    whole = at_least(a["delay"], a["periods"] * a["period"])
    goal = at_least(ceiling(a["y"], b, a.one), floor(a["y"], b, a.one))
    given = (*a.can_be_kept(), *sent, whole, at_least(a["periods"]))
    return Statement(a.symbols, (goal,), given)


@claim(
    "guard.delay.lemma",
    given="the delay is constant and at most as stated, the commands before the first sample are "
    "0, and max(|v|, f_speed) + delay max(net, 0)/M_min <= u1 at the start",
    by=HAND,
    premises="guard.lemma guard.delay.command guard.delay.command-angular guard.delay.queue "
    "guard.delay.upper guard.delay.lower",
)
def guard_delay_lemma() -> None:
    """v+ = max(v, f_speed) is at most max(y + nbar, f_speed) + ahead when the new command starts to
    act; by induction over the samples |v| <= u1 at every instant from then on.

    guard.lemma for one command under way after the other, then for the new one.
    """
