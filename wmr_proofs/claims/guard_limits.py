"""Optimality of the guard, necessity of its parts, and its theorems by hand.

Statements about one sample become statements about every instant of a run by the comparison lemma
(guard.lemma), used for each command under way and then for the new one, and by induction.
"""

from dataclasses import replace

from casadi import fmax

from wmr_ctrl.control.guard.delay import largest_force
from wmr_ctrl.control.guard.guard import ceiling, clipped, floor
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import Statement, equal, nonnegative, positive, symbols

from .guard_axis import AT_ONCE, DELAYED, EACH, LATE, GuardAxis
from .guard_sample import inside
from .guard_sent import only

claim = Claims()


@claim("guard.too-fast")
def too_fast(mutation: Mutation) -> Statement:
    """guard.inside with alpha T up to 1.01.

    False: alpha = 1/T is the fastest approach to the limit that a held force admits.

    Given: {GUARD_FREE}brake >= dbar - f_min, but alpha T <= 1.01.
    """
    return inside(-mutation, 1, GuardAxis(AT_ONCE))


@claim("guard.maximal")
def maximal(mutation: Mutation) -> Statement:
    """0 <= v <= u1 and F > hi(v): v + T (F + dbar)/M_min > u1.

    No guard that intervenes less is safe.

    Given: {NUMBERS_FREE}; nbar = f_min = f_speed = 0, alpha = 1/T.
    """
    a = GuardAxis()
    b = a.bounds
    exact = map(equal, (b.nbar, b.f_min, b.f_speed, 1 - b.alpha * b.period))
    given = a.feasible(), *exact, a.v >= 0, a.inside
    more = a.asked - ceiling(a.v, b)
    end = a.v + b.period * (a.asked + b.dbar) / mutation(b.M_min, b.M_max)
    return Statement(a, end > a.u1, (given, more > 0))


@claim("guard.necessary")
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


@claim(
    "guard.sides",
    each=EACH,
)
def sides(mutation: Mutation, a: GuardAxis) -> Statement:
    """with another limit for -v, hi is at least that of the guard whose one limit is the smaller of
    both, and the caps are that guard's; lo, -hi of -v, with the limits exchanged: at once, behind a
    delay, and late with jitter.

    So a safe force is left at every velocity (guard.feasible and those behind delays), and what is
    shown of one direction holds with its own limit.

    Given: T, M_min, alpha, u1, the limit of -v > 0, delay, jitter, mixed > 0 where they count;
    M_min <= M_max, alpha T <= 1; any v and any push under way.
    """
    t = symbols("behind", "behind")
    b, coming = replace(a.bounds, back=t.behind), a.coming
    one = replace(a.bounds, u1=mutation(1, 1.01) * b.narrow)
    goals = [ceiling(a.y, b, coming) >= ceiling(a.y, one, coming)]
    if not a.lateness:  # else the caps stand for any numbers
        goals.append(b.mirrored.braking == one.braking)
    late = [a.delay] * (a.lateness > AT_ONCE) + [a.jitter, a.mixed] * (a.lateness == LATE)
    given = (
        positive(a.period, a.M_min, a.alpha, a.u1, t.behind, *late), a.M_max >= a.M_min,
        a.alpha * a.period <= 1,
    )  # fmt: skip
    caps = {"brakes": b.braking, "largest": largest_force(b)} if a.lateness else {}
    return Statement(a | t, goals, given, caps)


@claim("guard.delay.longer")
def longer(_: Mutation) -> Statement:
    """guard.delay.inside, with a delay that is 1 % longer than stated.

    False: the delay may be stated too long, not too short.

    Given: one command under way.
    """
    a = GuardAxis(DELAYED)
    b = a.bounds
    reached = fmax(a.v, b.f_speed) + a.since * fmax(a.sent + a.net, 0) / a.mass
    force = clipped(a.asked, a.y, b, only(a))
    end = a.arrived + a.t * fmax(force + a.net, 0) / a.mass
    time = 1.01 * a.periods * a.period
    given = (
        a.sound(), a.capped, a.measured, a.during(), nonnegative(a.since, a.periods),
        time >= a.since, reached >= a.arrived, a.u1 >= a.arrived,
        a.arrived >= b.f_speed, ceiling(a.y, b, only(a)) >= floor(a.y, b, only(a)),
    )  # fmt: skip
    return Statement(a, a.u1 >= end, given, a.cuts)


@claim("guard.delay.uncapped")
def uncapped(_: Mutation) -> Statement:
    """guard.delay.feasible, with |F_j| <= M_min alpha (u1 - f_speed) - net.

    False: without the smaller cap a state can be reached that has no safe force.

    Given: {FEASIBLE}.
    """
    a = GuardAxis(DELAYED)
    b = a.bounds
    most = b.M_min * b.alpha * (b.u1 - b.f_speed) - a.net
    sent = (most >= a.sent, most >= -a.sent)
    whole = a.delay >= a.periods * a.period
    goal = ceiling(a.y, b, only(a)) >= floor(a.y, b, only(a))
    return Statement(a, goal, (a.feasible(), sent, whole, a.periods >= 0))
