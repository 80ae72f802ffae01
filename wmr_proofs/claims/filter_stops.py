"""Changing limits, and stops before obstacles, on one side of one axis.

E is the remaining share of the old speed; e1 and e2 are its least (tau_min, the longest time) and
its largest value (tau_max, the least time).  A is the distance per m/s of a decaying speed.
"""

from casadi import SX, fmax, fmin, if_else

from wmr_ctrl.control.filter.governor import FirstOrder, drive
from wmr_ctrl.control.filter.ramp_stop import stopping_speed
from wmr_ctrl.control.filter.ways import Reached, Stop, covered, farthest, told_command
from wmr_ctrl.control.guard.changing import largest_fall
from wmr_ctrl.control.guard.guard import Bounds
from wmr_proofs.claim import CLAIMED, Claims, Mutation
from wmr_proofs.statement import (
    Named,
    Relations,
    Statement,
    Symbols,
    between,
    nonnegative,
    positive,
    symbols,
)

from .command_filter import NUMBERS, admits

claim = Claims()


class Lowered(Named):
    """Symbols of a command that takes over at v <= v_bar while a limit V is in force."""

    def __init__(self, mutation: Mutation) -> None:
        self.symbols = symbols(f"{NUMBERS} kappa_2 u v v_bar mean E e1 e2", NUMBERS)
        self.bounds = FirstOrder(**{name: self[name] for name in NUMBERS.split()})
        e1, e2, E = self.e1, self.e2, self.E
        ratios = self.kappa * (1 - e1) == e1, self.kappa_2 * (1 - e2) == e2
        self.given: Relations = (
            admits(self.bounds), e1 > 0, e2 >= e1, e2 < 1, ratios,
            between(e1, E, mutation(1, 1.01) * e2), E <= 1,
            self.v_bar >= self.v, drive(self.u, self.bounds) >= self.mean,
        )  # fmt: skip
        self.hi = told_command(self.V, self.v_bar, self.bounds, self.kappa_2)
        self.end = E * self.v + (1 - E) * self.mean

    def stopped(self, share: SX) -> SX:
        """Largest of V and the bound of the speed that a stop leaves."""
        return fmax(self.V, self.dbar + share * (self.v_bar - self.dbar))


@claim("filter.limits.enters")
def enters(mutation: Mutation) -> Statement:
    """E v + (1 - E) mean <= max(V, dbar + E (v_bar - dbar)), and <= v_bar.

    A base above a limit is within it no later than a stop would bring it there.

    Given: {LOWERED}; V < v_bar, u <= hi, mean <= drive(u) (filter.drive).
    """
    a = Lowered(mutation)
    goals = a.stopped(a.E) >= a.end, a.v_bar >= a.end
    return a.states(goals, given=(a.given, a.v_bar > a.V, a.hi >= a.u))


@claim("filter.limits.inside")
def inside(mutation: Mutation) -> Statement:
    """E v + (1 - E) mean <= V, and hi >= 0.

    Below a limit it stays inside.

    Given: {LOWERED}; v_bar <= V, u <= hi, mean <= drive(u) (filter.drive).
    """
    a = Lowered(CLAIMED)
    goals = a.end <= a.V, a.hi >= 0
    return a.states(goals, given=(a.given, mutation(1, 0.99) * a.v_bar <= a.V, a.hi >= a.u))


@claim("filter.limits.no-larger")
def no_larger(mutation: Mutation) -> Statement:
    """e2 v_bar + (1 - e2)(K_max u + dbar) > max(V, dbar + e2 (v_bar - dbar)).

    Under a larger command the slowest base stays above the limit for longer than in a stop.

    Given: {LOWERED}; dbar < V <= v_bar, hi < u.
    """
    a = Lowered(CLAIMED)
    sent = a.u > mutation(1, 0.99) * a.hi, a.dbar < a.V, a.v_bar >= a.V
    end = a.e2 * a.v_bar + (1 - a.e2) * (a.K_max * a.u + a.dbar)
    return a.states(end > a.stopped(a.e2), given=(a.given, sent))


@claim("filter.free.brake")
def brake(mutation: Mutation) -> Statement:
    """Either speed is at most max(v_bar, 0).

    A brake that closes on a moving base leaves the bounds of both directions valid.

    Given: v <= v_bar; afterwards the speed is v, or 0.
    """
    t = symbols("v v_bar stands")
    after = if_else(t.stands > 0, mutation(0, 1), t.v)
    return Statement(t, fmax(t.v_bar, 0) >= after, t.v_bar >= t.v)


@claim("filter.free.way")
def way(mutation: Mutation) -> Statement:
    """x <= farthest(w, m, t).

    One of the two extreme time constants bounds the distance in a piece of time.

    Given: 0 <= A_least <= A <= A_most <= t; v <= w, x <= m t + (v - m) A; farthest(w, m, t) = m t +
    max((w - m) A_least, (w - m) A_most).
    """
    t = symbols("t A A_least A_most v w m x")
    rest = between(t.A, t.A_most, t.t), t.w >= t.v
    gone = t.m * t.t + (t.v - t.m) * t.A >= t.x
    goal = farthest(t.w, t.m, t.t, t.A_least, t.A_most) >= t.x
    return Statement(t, goal, (between(0, t.A_least, mutation(1, 1.01) * t.A), rest, gone))


RESTS = {"rest": {"rests": True}, "loop alone": {"rests": False}}
"""A base that stands and holds after a rest, or that its loop alone stops: no push then."""


class Plan(Named):
    """A command that takes over at w and acts for D, then 0 until the base stands.

    For both ends of tau: A = covered(D, tau), q = A/tau; A_B of the rest.
    """

    def __init__(self, rests: bool) -> None:
        self.symbols = t = symbols("tau_1 tau_2 push rest acts last free w way m")
        rest = t.rest if rests else None
        self.stop = Stop((t.tau_1, t.tau_2), t.push, rest, t.acts, t.last, SX(0))
        fades = [covered(t.acts + t.last, tau) for tau in (t.tau_1, t.tau_2)]
        self.A, self.fading = fades, self.stop.fading
        self.shares = [fade / tau for fade, tau in zip(fades, (t.tau_1, t.tau_2), strict=True)]
        D, self.at = t.acts + t.last, Reached(SX(0), t.way, t.w)
        self.given: Relations = (
            t.tau_1 > 0, t.tau_2 >= t.tau_1, nonnegative(t.push, t.rest),
            t.acts > 0, t.last >= 0, t.w >= t.push, fades[0] > 0,
            fades[1] >= fades[0], fades[1] < D, self.shares[1] > 0,
            self.shares[0] >= self.shares[1], self.shares[0] < 1,
            between(0, self.fading, t.rest) if rests else t.push == 0,
        )  # fmt: skip

    def needed(self, k: int, m: SX) -> SX:
        """Distance of the whole plan for one end of tau."""
        t = self.symbols
        D = t.acts + t.last
        end = t.w + (m - t.w) * self.shares[k]
        own = t.way + m * D + (t.w - m) * self.A[k]
        return own + self.fading * (end - t.push) + self.stop.creep

    def most(self, mutation: Mutation) -> SX:
        """Largest steady speed that the free distance admits."""
        return self.stop.steady(mutation(1, 1.01) * self.free, [self.at])


@claim("filter.free.plan", each=RESTS)
def plan(mutation: Mutation, rests: bool) -> Statement:
    """way + m D + (w - m) A + A_B (w + (m - w) q - d) + d B <= free, for both ends of tau.

    A command that the graph admits stops within the free distance for either end of tau.

    Given: {STOP}; 0 <= d <= w; m <= steady(free), the largest steady speed.
    """
    a = Plan(rests)
    goals = [a.free >= a.needed(k, a.m) for k in (0, 1)]
    return a.states(goals, given=(a.given, a.most(mutation) >= a.m))


@claim("filter.free.real")
def real(mutation: Mutation) -> Statement:
    """x_2 + x_3 <= the larger of both distances m D + (w - m) A + A_B (w + (m - w) q - d) + d B.

    The distance of the true base is at most that for one end of tau.

    Given: 0 <= d <= w, d <= m, v <= w; A and q of the true tau between those of its ends, 0 <= A <=
    D, 0 <= q <= 1, and 0 <= a_B <= A_B <= B; distance and speed under the command x_2 <= m D + (v -
    m) A, v_3 <= v + q (m - v), and x_3 <= max(v_3 - d, 0) a_B + d B, the distance during the rest.
    """
    t = symbols("D A_1 A_2 q_1 q_2 A_B d B w m v a q a_B x_2 v_3 x_3")
    ends = ((t.A_1, t.q_1), (t.A_2, t.q_2))
    ways = [
        t.m * t.D + (t.w - t.m) * A + t.A_B * (t.w + (t.m - t.w) * q - t.d) + t.d * t.B
        for A, q in ends
    ]
    given = (
        t.A_1 >= 0, between(mutation(1, 0.9) * t.A_1, t.a, t.A_2), t.D >= t.A_2,
        t.q_2 >= 0, between(t.q_2, t.q, t.q_1), t.q_1 <= 1, between(0, t.d, t.w),
        t.m >= t.d, t.w >= t.v, between(0, t.a_B, t.A_B), t.B >= t.A_B,
        t.m * t.D + (t.v - t.m) * t.a >= t.x_2,
        t.v + t.q * (t.m - t.v) >= t.v_3,
        fmax(t.v_3 - t.d, 0) * t.a_B + t.d * t.B >= t.x_3, t.A_2 >= t.A_1,
    )  # fmt: skip
    return Statement(t, fmax(*ways) >= t.x_2 + t.x_3, given)


@claim("filter.free.necessary", each=RESTS)
def necessary(mutation: Mutation, rests: bool) -> Statement:
    """The distance for one end of tau (filter.free.plan) exceeds the free one.

    No larger command stops every base in time.

    Given: {STOP}; 0 <= d <= w, d <= m; 0 < free, steady(free) < m.
    """
    a = Plan(rests)
    beyond = a.m > mutation(1, 0.99) * a.most(CLAIMED)
    goal = fmax(a.needed(0, a.m), a.needed(1, a.m)) > a.free
    return a.states(goal, given=(a.given, beyond, a.m >= a.push, a.free > 0))


def _leaving(mutation: Mutation, rests: bool = True) -> tuple[Symbols, Stop[SX], list[Relations]]:
    """Symbols of a released base: distance, speed at its start, and decayed speed."""
    t = symbols("tau_1 tau_2 push rest x_1 x_2 x_3 v_3 w a_B free target pull h q a")
    rest = t.rest if rests else None
    stop = Stop((t.tau_1, t.tau_2), t.push, rest, SX(0), SX(0), SX(0))
    least = stop.quick
    given: list[Relations] = [
        t.tau_1 > 0, nonnegative(t.rest, t.push, least),
        mutation(1, 1.01) * t.a_B >= least,
        t.rest >= t.a_B if rests else t.push == 0,
        t.push * t.rest + (t.v_3 - t.push) * t.a_B >= t.x_3,
    ]  # fmt: skip
    return t, stop, given


@claim("filter.leave.roll", each=RESTS)
def roll(mutation: Mutation, rests: bool) -> Statement:
    """x_3 <= d (B - A(B; tau_min)).

    Largest roll after one release of a command away.

    Given: {FADES}{ALONE}; 0 <= d, v_3 <= 0, x_3 <= d B + (v_3 - d) a_B.
    """
    t, stop, given = _leaving(mutation, rests)
    return Statement(t, stop.roll >= t.x_3, (given, -t.v_3 >= 0), {"minus_A_least": -stop.quick})


@claim("filter.free.retreat", each=RESTS)
def retreat(mutation: Mutation, rests: bool) -> Statement:
    """x_1 + x_2 + x_3 <= free, and x_1 + x_2 <= free.

    A command away that the distance admits rolls no farther than the free distance.

    Given: {FADES}{ALONE}; 0 <= d, v_3 <= s = max(w, target) <= 0, 0 <= x_1, x_2 <= 0, x_3 <= d B +
    (v_3 - d) a_B; x_1 + max(0, d B + (s - d) A(B; tau_min)) <= free; nothing comes nearer.
    """
    t, stop, given = _leaving(CLAIMED, rests)
    speed = fmax(t.w, t.target)
    given += [
        -speed >= 0, speed >= t.v_3, -t.x_2 >= 0,
        mutation(1, 1.01) * t.free >= stop.retreat(t.x_1, t.w, t.target), t.x_1 >= 0,
    ]  # fmt: skip
    goals = t.free >= t.x_1 + t.x_2 + t.x_3, t.free >= t.x_1 + t.x_2
    return Statement(t, goals, given)


@claim("filter.leave.hold")
def hold(mutation: Mutation) -> Statement:
    """x_2 + x_3 <= 0.

    After the hold a release ends no nearer than where the command began.

    Given: {FADES}; 0 <= d, 0 < p; a command with the pull p acts for h >= hold(p) = d (B - A(B;
    tau_min))/p + tau_max - A(B; tau_min) from rest: x_2 <= -p (h - a), v_3 <= -p q, 0 <= a <=
    tau_max q, 0 <= q <= 1; x_3 <= d B + (v_3 - d) a_B.
    """
    t, stop, given = _leaving(CLAIMED)
    given += [
        t.pull > 0, t.tau_2 >= stop.quick, between(0, t.q, 1),
        t.h >= mutation(1, 0.9) * stop.hold(t.pull), between(0, t.a, t.tau_2 * t.q),
        -t.pull * (t.h - t.a) >= t.x_2, -t.pull * t.q >= t.v_3,
    ]  # fmt: skip
    return Statement(t, -t.x_2 >= t.x_3, given)


@claim("filter.leave.away")
def away(mutation: Mutation) -> Statement:
    """K u + push <= 0; E v + (1 - E)(K u + push) <= 0; (K u + push) t + (v - K u - push) A <= 0.

    From rest the base does not creep back under a command away, for any push.

    Given: 0 < K_min <= K, |push| <= d; u <= -d/K_min; v <= 0, 0 <= E <= 1, 0 <= A <= t.
    """
    t = symbols("K_min K u d push v E A t")
    target = t.K * t.u + t.push
    given = (
        t.K_min > 0, mutation(1, 1.01) * t.K >= t.K_min, t.d >= t.push,
        t.d >= 0, -t.d >= t.K_min * t.u, -t.v >= 0, between(0, t.E, 1),
        between(0, t.A, t.t),
    )  # fmt: skip
    way = target * t.t + (t.v - target) * t.A
    goals = -target >= 0, -t.E * t.v >= (1 - t.E) * target, -way >= 0
    return Statement(t, goals, given)


@claim("filter.free.ramp")
def ramp(mutation: Mutation) -> Statement:
    """m h + m^2/(2 A) <= room.

    A base that slows down by A stops within its room.

    Given: 0 < A, h; 0 <= room; 0 <= m <= stopping_speed(room) = A (sqrt(h^2 + 2 room/A) - h).
    """
    t = symbols("A h room m")
    A, h, room, m = t.values()
    most = mutation(1, 1.01) * stopping_speed(room, h, A)
    goal = room >= m * h + m * m / (2 * A)
    return Statement(t, goal, (positive(A, h), room >= 0, between(0, m, most)))


@claim("guard.falling")
def falling(mutation: Mutation) -> Statement:
    """v_1 <= V_1, and the fall is at least 0.

    A limit that falls no faster than the guard surely brakes is kept.

    Given: 0 < M_min <= M <= M_max, alpha, T > 0, 0 <= net <= brake; limits V_0 this way and U_0 the
    other way, then V_1 and U_1; f_speed <= told, the smaller one of those that are told, told <=
    V_1, U_1; V_0 - largest_fall <= V_1, U_0 - largest_fall <= U_1; v <= V_0, v_1 <= max(V_1, v - T
    max(braking - net, 0)/M), braking = min(brake, M_min alpha (min(V_1, U_1) - f_speed) - net).
    """
    names = "M_min M_max dbar f_min f_speed nbar alpha brake M T v v_1 V_0 V_1 U_0 U_1 told"
    t = symbols(names)
    b = Bounds(u1=t.V_1, back=t.U_1, period=t.T, **{key: t[key] for key in names.split()[:8]})
    fall = largest_fall(b, [t.V_0, t.U_0], [t.told, t.told])
    reached = fmax(t.V_1, t.v - t.T * fmax(fmin(b.brake, b.cap) - b.net, 0) / t.M)
    given = (
        positive(t.M_min, t.T, t.alpha), between(t.M_min, t.M, t.M_max), t.v <= t.V_0,
        between(0, b.net, b.brake), between(t.f_speed, t.told, b.narrow),
        t.V_0 - mutation(1, 1.1) * fall <= t.V_1, t.U_0 - fall <= t.U_1, reached >= t.v_1,
    )  # fmt: skip
    return Statement(t, (t.v_1 <= t.V_1, fall >= 0), given)
