"""The guard with late velocities, jitter and lag: there is always a safe force."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from wmr_ctrl.guard.bounds import ROUNDING
from wmr_ctrl.guard.delay import InFlight, Tails, in_flight
from wmr_ctrl.guard.guard import clipped, feasible
from wmr_ctrl.guard.lateness import AT_ONCE, Tail
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard_axis import LateAxis
from wmr_ctrl.proofs.claims.guard_latest import CAPS, COUNTED, LatestAxis, rooms_of
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols

FEASIBLE = (
    "2 net (1 + alpha late) <= M_min alpha (u1 - f_speed), 2 net mixed <= M_min (u1 - 2 nbar), "
    "net = dbar - f_min, 2 nbar <= u1, brake >= net, alpha T <= 1, J <= T; every other number free"
)


def _enough(a: LatestAxis, ahead: ca.SX, back: ca.SX, more: float = 1) -> Relation:
    """Either room, or both together, are what braking needs."""
    b = a.bounds
    most = ca.fmax(ca.fmax(ahead, back), ahead + back)
    return at_least(more * b.M_min * b.alpha * most, ca.fmax(b.braking + a.net, 0))


def _spares(a: LatestAxis) -> tuple[ca.SX, ca.SX]:
    """What is left when the new command may first take over, either way."""
    b, coming = a.bounds, a.coming
    ahead = b.u1 - coming.reached(ca.fmax(a["y"] + b.nbar, b.f_speed), b)
    return ahead, b.u1 - coming.mirrored.reached(ca.fmax(-a["y"] + b.nbar, b.f_speed), b)


def _spared(a: LatestAxis, ahead: ca.SX, back: ca.SX, more: float = 1) -> Relation:
    """Either, or both together, are what braking and the last command need."""
    b = a.bounds
    braking = ca.fmax(b.braking + a.net, 0) / b.alpha
    again = a.J * (a.largest + a.net)
    one, two = (b.M_min * x - braking for x in (ca.fmax(ahead, back), ahead + back))
    return at_least(ca.fmax(one - more * again, two - 2 * more * again))


def _any_rooms(a: LatestAxis) -> tuple[dict[str, ca.SX], dict[str, ca.SX]]:
    """Symbols for both rooms, and what they stand for, beside the caps."""
    t = symbols("room_ahead room_back")
    return t, {**a.cuts, **dict(zip(t, rooms_of(a), strict=True))}


claim = Claims(by=Z3(effort=400))


@claim("guard.late.caps", given=FEASIBLE)
def caps(mutation: Mutation) -> Statement:
    """0 <= brakes, net <= brakes <= largest, late (largest + net) + max(brakes + net, 0)/alpha <=
    M_min (u1 - f_speed), and mixed (largest + net) <= M_min (u1 - 2 nbar).

    The caps share the room between rest and the limit, and leave what jitter needs.
    """
    a = LatestAxis()
    goals = (*a.capped, a.shared(mutation(1, 1.01)), a.apart())
    given = (*a.can_be_kept(), a.spread)
    return Statement(a.symbols, goals, given)


@claim("guard.late.mixed", given=FEASIBLE)
def caps_mixed(mutation: Mutation) -> Statement:
    """mixed (largest + net) <= M_min (u1 - 2 nbar), by itself.

    The part of guard.late.caps that jitter brings, with a mutation of its own.
    """
    a = LatestAxis()
    given = (*a.can_be_kept(), a.spread)
    return Statement(a.symbols, (a.apart(mutation(1, 0.99)),), given)


@claim(
    "guard.late.piece",
    given=f"|F_j| <= largest, M_min <= M <= M_max; {CAPS}",
    premises="guard.late.caps",
)
def guard_late_piece(mutation: Mutation) -> Statement:
    """a piece of time in which either of two commands acts adds at most what it is counted for,
    whichever acts and for however long, and each way at most its time (largest + net)/M_min.

    Jitter: the guard counts the worse of the two, forwards and backwards.
    """
    a = LateAxis()
    b, time = a.bounds, a["periods"] * a["period"]
    first, second = a["sent"], a["asked"]
    both = ca.horzcat(ca.vertcat(first, a["other"]), ca.vertcat(second, a["other"]))
    piece = in_flight([(both, a["periods"])], 0, b)
    goals = []
    for force in (first, second):
        for way, counted in ((1, piece.ahead), (-1, piece.back)):
            reached = a["since"] * ca.fmax(way * force + a.net, 0) / a["mass"]
            goals.append(at_least(counted, mutation(1, 1.01) * reached))
    most = time * (a.largest + a.net) / b.M_min
    goals += [at_least(most, piece.ahead), at_least(most, piece.back)]
    sent = [at_least(a.largest, way * force) for way in (1, -1) for force in (first, second)]
    during = (at_least(a["since"]), at_least(time, a["since"]), at_least(a["periods"]))
    given = (*a.sound(), *a.capped, *a.during, *sent, *during)
    return Statement(a.symbols, tuple(goals), given)


@claim(
    "guard.late.tail",
    given="decay 1/2, entering 1/4 and 1/8, one command listed; forces, net and M_min free",
)
def guard_late_tail(mutation: Mutation) -> Statement:
    """behind a lag, what is counted for older commands is decay of what it was and what the oldest
    listed command adds; both axes, starting from where a force of 0 leads.

    Commands of any age are counted with one number for each axis and direction.
    """
    # A sample later the tail is what stays of it and what joins, from steady at first.
    a = LateAxis()
    b, t = a.bounds, symbols("force1 force2 other1 other2")
    tail = Tail(decay=0.5, entering=(0.25, 0.125), share=1.0, steady=0.75)
    late = replace(AT_ONCE, commands=1, jitter=0.5, lag=1.0, tail=tail)
    tails = Tails("tail", (late, late))
    forces = [ca.vertcat(t[f"force{i}"], t[f"other{i}"]) for i in (1, 2)]
    state = tails.state[0].sym
    following = tails.following(forces, b)
    table = {**a.symbols, **t, **{f"tail{i}": state[i] for i in range(4)}}
    goals = []
    for axis in (0, 1):
        now = tails.added(InFlight(ca.SX(0), ca.SX(0)), axis, b)
        after = following[2 * axis] + tail.steady * b.period * ca.fmax(b.net, 0)
        old, new = forces[1][axis], forces[0][axis]
        joined = 0.25 * ca.fmax(old + b.net, 0) + 0.125 * ca.fmax(ca.fmax(old, new) + b.net, 0)
        wanted = 0.5 * now.ahead + mutation * b.period * joined / b.M_min
        goals.append(equal(after / b.M_min, wanted))
    given = (above(b.M_min), above(b.period))
    return Statement(table, tuple(goals), given)


@claim("guard.late.spare", given=f"{COUNTED}; {CAPS}", premises="guard.late.caps guard.late.piece")
def spare(mutation: Mutation) -> Statement:
    """M_min times what is left when the new command may first take over, ahead or behind, is at
    least max(brakes + net, 0)/alpha + J S, or both together that + 2 J S, S = largest + net.

    What was sent never takes the room that braking needs.
    """
    a = LatestAxis()
    goal = _spared(a, *_spares(a), mutation(1, 1.01))
    given = (*a.sound(), *a.capped, *a.moving, a.shared(), a.apart(), *a.added())
    return Statement(a.symbols, (goal,), given, a.cuts)


@claim("guard.late.room", given="guard.late.spare", premises="guard.late.spare")
def room(mutation: Mutation) -> Statement:
    """M_min alpha room >= max(brakes + net, 0) ahead, or behind, or for both rooms together.

    The same once the last command may act for J more.
    """
    a = LatestAxis()
    b = a.bounds
    t = symbols("spare_ahead spare_back")
    cuts = dict(zip(t, _spares(a), strict=True))
    most = a.J * (a.largest + a.net) / b.M_min
    cuts |= {"again_ahead": a.again.ahead, "again_back": a.again.back}
    t |= symbols("again_ahead again_back")
    again = at_least(most, t["again_ahead"] + t["again_back"])
    signs = (at_least(t["again_ahead"]), at_least(t["again_back"]))
    goal = _enough(a, *rooms_of(a), mutation(1, 0.99))
    positive = tuple(above(item) for item in (b.M_min, b.alpha, b.period, a.J))
    given = (*positive, *a.capped, *signs, again, _spared(a, t["spare_ahead"], t["spare_back"]))
    return Statement({**a.symbols, **t}, (goal,), given, {**a.cuts, **cuts})


@claim(
    "guard.late.feasible",
    given="guard.late.room, 2 nbar <= u1, alpha T <= 1",
    premises="guard.late.room",
)
def guard_late_feasible(mutation: Mutation, varies: bool = True) -> Statement:
    """lo(y) <= hi(y) for every y, whatever was sent.

    There is always a safe force: nothing has to be checked while it runs.
    """
    a = LatestAxis(varies=varies)
    t, cuts = _any_rooms(a)
    enough = _enough(a, t["room_ahead"], t["room_back"], mutation(1, 1.01))
    return Statement(
        {**a.symbols, **t}, (at_least(a.hi, a.lo),), (*a.sound(), *a.capped, enough), cuts
    )


@claim("guard.late.largest", given=CAPS, premises="guard.late.caps")
def largest(mutation: Mutation) -> Statement:
    """|F| <= largest.

    Commands stay as small as those before them were assumed to be.
    """
    a = LatestAxis()
    most = mutation(1, 0.99) * a.largest
    goals = (at_least(most, a.force), at_least(most, -a.force))
    t, cuts = _any_rooms(a)
    return Statement({**a.symbols, **t}, goals, (*a.sound(), *a.capped), cuts)


@claim("guard.late.anchor", given=CAPS, premises="guard.late.caps")
def anchor(mutation: Mutation) -> Statement:
    """|clip(0, lo, hi)| <= brakes.

    The force of least effort is within the brake cap: the wheel maps keep the box.
    """
    a = LatestAxis()
    b = a.bounds
    size = ca.fabs(clipped(ca.SX(0), a["y"], b, a.coming))
    most = mutation(1, 0.99) * b.braking
    t, cuts = _any_rooms(a)
    return Statement({**a.symbols, **t}, (at_least(most, size),), (*a.sound(), *a.capped), cuts)


@claim("guard.late.promise", given="with jitter")
def promise(mutation: Mutation) -> Statement:
    """feasible = 1 implies the inequalities of guard.late.caps, 2 nbar <= u1, brake >= net, M_min
    <= M_max, f_speed < u1 and alpha T <= 1 + 2^-44.

    The published flag stands for the theorem's hypotheses, signs aside and alpha T to rounding.
    """
    a = LatestAxis()
    b = a.bounds
    need = mutation(2, 2.01) * a.net * (1 + b.alpha * a["delay"])
    goals = (
        at_least(b.M_min * b.alpha * (b.u1 - b.f_speed), need), a.spread,
        at_least(b.u1, 2 * b.nbar), at_least(b.brake, a.net), at_least(b.M_max, b.M_min),
        at_least(1 + ROUNDING, b.alpha * b.period), above(b.u1, b.f_speed),
    )  # fmt: skip
    return Statement(a.symbols, goals, (above(feasible(b)),))


@claim(
    "guard.late.steady.room",
    given=f"{COUNTED}, J = mixed = 0; {CAPS}",
    premises="guard.late.caps guard.late.piece",
)
def roomy(mutation: Mutation) -> Statement:
    """guard.late.room for a delay that does not vary.

    The same without jitter, whose graph is another.
    """
    a = LatestAxis(varies=False)
    goal = _enough(a, *rooms_of(a), mutation(1, 0.99))
    given = (*a.sound(), *a.capped, *a.moving, a.shared(), *a.added())
    return Statement(a.symbols, (goal,), given, a.cuts)


@claim(
    "guard.late.steady.feasible",
    given="guard.late.steady.room, 2 nbar <= u1, alpha T <= 1",
    premises="guard.late.steady.room",
)
def guard_late_steady_feasible(mutation: Mutation) -> Statement:
    """guard.late.feasible for a delay that does not vary.

    There is always a safe force, without jitter.
    """
    return guard_late_feasible(mutation, False)
