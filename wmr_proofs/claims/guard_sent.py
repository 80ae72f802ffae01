"""Push of the commands in transit, and the room that the guard leaves for braking.

For any number of commands: the contribution of one command is proved for that command, everything
else for their sums.  Further claims: the guard is optimal, its parts are needed, and each direction
may have its own limit.
"""

from dataclasses import replace

from casadi import SX, fmax, horzcat, logic_and, vertcat

from wmr_ctrl.control.guard.delay import InFlight, Tails, in_flight, largest_force
from wmr_ctrl.control.guard.guard import ceiling, clipped, floor
from wmr_ctrl.control.guard.lateness import AT_ONCE, Tail
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Relations,
    Statement,
    at_least,
    between,
    column,
    equal,
    nonnegative,
    positive,
    symbols,
    when,
)

from .guard_axis import DELAYED, EACH, LATE, GuardAxis
from .guard_sample import inside, on

claim = Claims()


def only(a: GuardAxis, place: int = 0) -> InFlight:
    """Push of a single command ``sent`` in transit; ``place``: its axis."""
    pair = [a.other, a.other]
    pair[place] = a.sent
    return in_flight([(vertcat(*pair), a.periods)], place, a.bounds)


def larger(one: SX, other: SX) -> SX:
    """Either, or both together."""
    return fmax(fmax(one, other), one + other)


@claim(
    "guard.{name}",
    over=(
        {"name": "delay.caps", "a": GuardAxis(DELAYED), "given": "{FEASIBLE}", "told": ""},
        {"name": "late.caps", "a": GuardAxis(LATE), "given": "{JITTERY}", "told": "{JITTERS}"},
    ),
)
def caps(mutation: Mutation, a: GuardAxis) -> Statement:
    """brakes = min(brake, cap): 0 <= brakes, net <= brakes <= largest, and late (largest +
    net)/M_min + max(brakes + net, 0)/(M_min alpha) <= u1 - f_speed{told}.

    The caps divide the room between rest and the limit among late commands, braking and jitter.

    Given: {given}.
    """
    spread = [] if a.both_act.is_zero() else [a.apart(mutation(1, 0.99))]
    goals = a.capped, a.shared(mutation(1, 1.01)), spread
    return Statement(a, goals, a.feasible())


@claim(
    "guard.delay.command", over=on("delay."), each={"linear": {"place": 0}, "angular": {"place": 1}}
)
def command(mutation: Mutation, place: int) -> Statement:
    """max(F_j + net, 0) + max(net - F_j, 0) <= largest + net for a single command in transit, and v
    and -v are at most the guard's bound as long as it acts; on each axis, for any command on the
    other.

    The guard assumes the largest effect of a command in transit, even if it acts for a shorter
    time.

    Given: one command; |F_j| <= largest, |y - v| <= nbar, M_min <= M <= M_max; {caps}.
    """
    a = GuardAxis(DELAYED)
    one, b, time = only(a, place), a.bounds, a.periods * a.period
    most = mutation(1, 0.99) * time * a.S / b.M_min
    goals = [most >= one.ahead + one.back]
    for way, coming in ((1, one.ahead), (-1, one.back)):
        reached = fmax(way * a.v, b.f_speed) + a.since * fmax(way * a.sent + a.net, 0) / a.mass
        goals.append(fmax(way * a.y + b.nbar, b.f_speed) + coming >= reached)
    sent = (a.largest >= a.sent, a.largest >= -a.sent)
    during = (between(0, a.since, time), a.periods >= 0)
    return Statement(a, goals, (a.stated, a.measured, a.during(), sent, during))


@claim("guard.delay.queue")
def queue(mutation: Mutation) -> Statement:
    """the sums of n commands in transit, ahead and back, are those of n - 1 commands plus that of
    the last one, for both axes, n = 1 to 5.

    A result for one more command extends to all of them together.

    Given: any forces and times.
    """
    a = GuardAxis(DELAYED)
    t = column("F", 5) | column("N", 5) | column("time", 5)
    sent = [(vertcat(t[f"F{j}"], t[f"N{j}"]), t[f"time{j}"]) for j in range(1, 6)]
    goals = []
    for axis in (0, 1):
        for n in range(1, 6):
            every, last = (in_flight(part, axis, a.bounds) for part in (sent[:n], sent[n - 1 : n]))
            rest = in_flight(sent[: n - 1], axis, a.bounds)
            goals.append(every.ahead == rest.ahead + mutation * last.ahead)
            goals.append(every.back == rest.back + last.back)
    return Statement(a | t, goals, positive(a.bounds.M_min))


@claim("guard.late.piece", premises="guard.late.caps")
def late_piece(mutation: Mutation) -> Statement:
    """a piece of time in which either of two commands acts contributes at most its assumed push,
    whichever acts and for however long, and in each direction at most its time (largest +
    net)/M_min.

    Jitter: the guard assumes the worse of the two, forwards and backwards.

    Given: |F_j| <= largest, M_min <= M <= M_max; {CAPS}.
    """
    a = GuardAxis(DELAYED)
    b, time = a.bounds, a.periods * a.period
    first, second = a.sent, a.asked
    both = horzcat(vertcat(first, a.other), vertcat(second, a.other))
    piece = in_flight([(both, a.periods)], 0, b)
    goals = []
    for force in (first, second):
        for way, counted in ((1, piece.ahead), (-1, piece.back)):
            reached = a.since * fmax(way * force + a.net, 0) / a.mass
            goals.append(counted >= mutation(1, 1.01) * reached)
    most = time * a.S / b.M_min
    goals += [most >= piece.ahead, most >= piece.back]
    sent = [a.largest >= way * force for way in (1, -1) for force in (first, second)]
    during = (between(0, a.since, time), a.periods >= 0)
    return Statement(a, goals, (a.stated, a.during(), sent, during))


@claim("guard.late.tail")
def late_tail(mutation: Mutation) -> Statement:
    """behind a lag, the stored sum of older commands is decay times its last value plus the
    contribution of the oldest listed command; both axes and directions.  A stored 0 is the sum for
    forces of 0 for ever, and it stays 0 as long as they are 0.

    One number for each axis and direction covers commands of any age.

    Given: decay 1/2, entering 1/4 and 1/8, one command listed; forces, net and M_min free.
    """
    # A sample later the tail is what stays of it and what joins, from steady at first.
    a = GuardAxis(DELAYED)
    b, t = a.bounds, symbols("force1 force2 other1 other2")
    tail = Tail(decay=0.5, entering=(0.25, 0.125), share=1.0, steady=0.75)
    late = replace(AT_ONCE, commands=1, jitter=0.5, lag=1.0, tail=tail)
    tails = Tails("tail", (late, late))
    forces = [vertcat(t[f"force{i}"], t[f"other{i}"]) for i in (1, 2)]
    state = tails.state[0].sym
    following = tails.following(forces, b)
    table = a | t | {f"tail{i}": state[i] for i in range(4)}
    goals = list[Relations]()
    for axis in (0, 1):
        counted = tails.added(InFlight(SX(0), SX(0)), axis, b)
        steady = tail.steady * b.period * fmax(b.net, 0)
        old, new = forces[1][axis], forces[0][axis]
        for place, (way, now) in enumerate(((1, counted.ahead), (-1, counted.back))):
            kept, later = (x[2 * axis + place] for x in (state, following))
            both = fmax(fmax(way * old, way * new) + b.net, 0)
            joined = 0.25 * fmax(way * old + b.net, 0) + 0.125 * both
            wanted = 0.5 * now + mutation * b.period * joined / b.M_min
            goals.append((later + steady) / b.M_min == wanted)
            unmoved = logic_and(logic_and(old == 0, new == 0), kept == 0)
            goals += [when(unmoved, later == 0), when(kept == 0, now == steady / b.M_min)]
    return Statement(table, goals, positive(b.M_min, b.period))


def added(a: GuardAxis) -> Relations:
    """Bounds on sums of commands that keep to ``largest``."""
    most = a.S / a.bounds.M_min
    if a.lateness < LATE:
        return (a.late * most >= a.ahead + a.back,)
    rest, again = (a.late - a.J) * most, a.again
    mean = (a.usual + a.both_act - 2 * a.J) * most >= a.ahead + a.back
    last = at_least(a.J * most, again.ahead + again.back), positive(a.bounds.M_min)
    longer = a.rest_ahead >= a.ahead, a.rest_back >= a.back
    return rest >= a.rest_ahead, rest >= a.rest_back, mean, last, longer


def spares(a: GuardAxis) -> tuple[SX, SX]:
    """Room left when the new command may first take over, either way."""
    b, coming = a.bounds, a.sums
    ahead = b.u1 - coming.reached(fmax(a.y + b.nbar, b.f_speed), b)
    return ahead, b.u1 - coming.mirrored.reached(fmax(-a.y + b.nbar, b.f_speed), b)


def _spared(a: GuardAxis, ahead: SX, back: SX, more: float = 1) -> Relations:
    """Either room, or both together, are enough for braking and the last command."""
    b = a.bounds
    braking, again = fmax(b.braking + a.net, 0) / b.alpha, a.J * a.S
    one, two = (b.M_min * x - braking for x in (fmax(ahead, back), ahead + back))
    return fmax(one - more * again, two - 2 * more * again) >= 0


@claim("guard.late.spare", premises="guard.late.caps guard.late.piece")
def late_spare(mutation: Mutation) -> Statement:
    """M_min times the room when the new command may first take over, ahead or behind, is at least
    max(brakes + net, 0)/alpha + J S, or both rooms together this + 2 J S, S = largest + net.

    Commands already sent never use the room that braking needs.

    Given: {COUNTED}; {CAPS}.
    """
    a = GuardAxis(LATE)
    given = a.stated, a.moving, a.shared(), a.apart(), added(a)
    return Statement(a, _spared(a, *spares(a), mutation(1, 1.01)), given, a.cuts)


@claim("guard.late.room", premises="guard.late.spare")
def late_room(mutation: Mutation) -> Statement:
    """M_min alpha room >= max(brakes + net, 0) ahead, or behind, or for both rooms together.

    Room for braking, also if the last command acts for J more.

    Given: guard.late.spare.
    """
    a = GuardAxis(LATE)
    b, t = a.bounds, symbols("spare_ahead spare_back again_ahead again_back")
    spared = (*spares(a), a.again.ahead, a.again.back)
    again = a.J * a.S / b.M_min >= t.again_ahead + t.again_back
    signs = positive(b.M_min, b.alpha, b.period, a.J), a.capped
    sums = nonnegative(t.again_ahead, t.again_back), again
    given = signs, sums, _spared(a, t.spare_ahead, t.spare_back)
    goal = a.enough(a.left, mutation(1, 0.99))
    return Statement(a | t, goal, given, a.cuts | dict(zip(t, spared, strict=True)))


@claim(
    "guard.{at}{only}room",
    premises="{capped} guard.{one}",
    over=(
        on("delay.")[0]
        | {
            "sums": "0 <= ahead, back; ahead + back <= delay (largest + net)/M_min",
            "one": "delay.command",
        },
        on("late.steady.")[0] | {"sums": "{COUNTED}; J = mixed = 0", "one": "late.piece"},
    ),
)
def room(mutation: Mutation, a: GuardAxis) -> Statement:
    """commands in transit leave max(brakes + net, 0) of M_min alpha room, ahead or behind or of
    both rooms together; behind a delay alone of M_min alpha (u1 - f_speed - ahead - back).

    Commands in transit never use the room that braking needs.

    Given: {sums}; {caps}.
    """
    given = a.stated, a.moving, a.shared(), added(a)
    return Statement(a, a.enough(a.left, mutation(1, 0.99)), given, a.cuts)


@claim("guard.late.{name}",  over=(
    {"name": "rest", "part": "or from rest over the window", "rest": True,
     "so": "Why the guard counts from the oldest instant, too."},
    {"name": "half", "part": "and not from rest", "rest": False,
     "so": "False: half the window is not enough, since friction can stop the robot inside it."},
))  # fmt: skip
def late_rest(mutation: Mutation, rest: bool) -> Statement:
    """v = share window p/M_min, reached if friction has stopped the robot with a share of the
    window left, is at most the guard's bound from the mean, {part}.

    {so}

    Given: one command in the window, v = -V before; {SIGNS}.
    """
    a = GuardAxis(DELAYED)
    b, t = a.bounds, symbols("V share window")
    window, share = t.window, t.share
    v = share * window * fmax(a.sent + a.net, 0) / b.M_min
    y = share * v / 2 - (1 - share) * t.V
    pair, periods = vertcat(a.sent, 0), window / b.period
    mean, whole = (in_flight([(pair, part * periods)], 0, b) for part in (0.5, 1.0))
    coming = InFlight(mean.ahead, mean.back, whole if rest else None)
    reached = coming.reached(fmax(y + b.nbar, b.f_speed), b)
    given = a.sound(), positive(window), between(0, share, 1), between(0, t.V, b.u1)
    return Statement(a | t, reached >= mutation(1, 1.01) * v, given)


limits_claim = Claims()


@limits_claim("guard.too-fast")
def too_fast(mutation: Mutation) -> Statement:
    """guard.inside with alpha T up to 1.01.

    False: alpha = 1/T is the fastest approach to the limit that a held force admits.

    Given: {GUARD_FREE}brake >= dbar - f_min, but alpha T <= 1.01.
    """
    return inside(-mutation, 1, GuardAxis())


@limits_claim("guard.maximal")
def maximal(mutation: Mutation) -> Statement:
    """0 <= v <= u1 and F > hi(v): v + T (F + dbar)/M_min > u1.

    No guard that changes forces less is safe.

    Given: {NUMBERS_FREE}; nbar = f_min = f_speed = 0, alpha = 1/T.
    """
    a = GuardAxis()
    b = a.bounds
    exact = map(equal, (b.nbar, b.f_min, b.f_speed, 1 - b.alpha * b.period))
    given = a.feasible(), *exact, a.v >= 0, a.inside
    more = a.asked - ceiling(a.v, b)
    end = a.v + b.period * (a.asked + b.dbar) / mutation(b.M_min, b.M_max)
    return Statement(a, end > a.u1, (given, more > 0))


@limits_claim("guard.necessary")
def necessary(mutation: Mutation) -> Statement:
    """2 dbar (T + delay) > M_min u1 and F + dbar <= 0: (T + delay) (dbar - F)/M_min > u1.

    Beyond this bound no guard at all can keep the limit: friction of unknown size may stop the
    robot just after a sample.

    Given: u1, T, M_min, dbar > 0, delay >= 0.
    """
    t = symbols("u1 period M_min dbar delay force")
    u1, period, mass, dbar, delay, force = t.values()
    time = period + delay
    tight = 2 * dbar * time > mutation(1, 0.99) * mass * u1
    sizes = positive(u1, period, mass, dbar), nonnegative(delay, -force - dbar)
    return Statement(t, time * (dbar - force) / mass > u1, (sizes, tight))


@limits_claim("guard.sides", each=EACH)
def sides(mutation: Mutation, a: GuardAxis) -> Statement:
    """with another limit for -v, hi is at least that of the guard with the smaller of both limits,
    and the caps are those of that guard; lo is -hi of -v, with the limits exchanged.  This holds
    without lateness, behind a delay, and with jitter.

    So a safe force exists at every velocity (guard.feasible and its variants for delays), and
    results for one direction hold with its own limit.

    Given: T, M_min, alpha, u1, the limit of -v > 0, delay, jitter, mixed > 0 if present; M_min <=
    M_max, alpha T <= 1; any v and any push in transit.
    """
    t = symbols("behind", "behind")
    b, coming = replace(a.bounds, back=t.behind), a.coming
    one = replace(a.bounds, u1=mutation(1, 1.01) * b.narrow)
    goals = [ceiling(a.y, b, coming) >= ceiling(a.y, one, coming)]
    if not a.lateness:  # else the caps stand for any numbers
        goals.append(b.mirrored.braking == one.braking)
    late = [a.delay] * bool(a.lateness) + [a.jitter, a.mixed] * (a.lateness == LATE)
    given = (
        positive(a.period, a.M_min, a.alpha, a.u1, t.behind, *late), a.M_max >= a.M_min,
        a.alpha * a.period <= 1,
    )  # fmt: skip
    caps = {"brakes": b.braking, "largest": largest_force(b)} if a.lateness else {}
    return Statement(a | t, goals, given, caps)


@limits_claim("guard.delay.longer")
def longer(_: Mutation) -> Statement:
    """guard.delay.inside, with a delay that is 1 % longer than stated.

    False: the delay may be stated too long, not too short.

    Given: one command in transit.
    """
    a = GuardAxis(DELAYED)
    b = a.bounds
    reached = fmax(a.v, b.f_speed) + a.since * fmax(a.sent + a.net, 0) / a.mass
    end = a.arrived + a.t * fmax(clipped(a.asked, a.y, b, only(a)) + a.net, 0) / a.mass
    time = 1.01 * a.periods * a.period
    given = (
        a.sound(), a.capped, a.measured, a.during(), nonnegative(a.since, a.periods),
        time >= a.since, reached >= a.arrived, a.u1 >= a.arrived,
        a.arrived >= b.f_speed, ceiling(a.y, b, only(a)) >= floor(a.y, b, only(a)),
    )  # fmt: skip
    return Statement(a, a.u1 >= end, given, a.cuts)


@limits_claim("guard.delay.uncapped")
def uncapped(_: Mutation) -> Statement:
    """guard.delay.feasible, with |F_j| <= M_min alpha (u1 - f_speed) - net.

    False: without the smaller cap a state can be reached that has no safe force.

    Given: {FEASIBLE}.
    """
    a = GuardAxis(DELAYED)
    b = a.bounds
    most = b.M_min * b.alpha * (b.u1 - b.f_speed) - a.net
    sent = (most >= a.sent, most >= -a.sent)
    goal = ceiling(a.y, b, only(a)) >= floor(a.y, b, only(a))
    return Statement(a, goal, (a.feasible(), sent, a.delay >= a.periods * a.period, a.periods >= 0))
