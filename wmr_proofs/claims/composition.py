"""Compositions of parts, and the pieces of arguments by hand.

The parts are desired motions, dead reckoning, and the prediction to the time when a command acts.
The pieces are steps of sums, motions, and derivatives of logarithm and sine; the integrals, means
and inductions themselves are in docs/lemmas.md.  About sine and cosine, the solver knows at most
(sin t)^2 + (cos t)^2 = 1; `lemma.integration` derives the inequality from a derivative's sign.
"""

from functools import reduce
from itertools import pairwise

from casadi import SX, cos, fmax, fmin, gradient, jacobian, log, logic_or, sin, substitute, vertcat

from wmr_ctrl.control.guard.delay import Tails, delayed_push, push
from wmr_ctrl.control.guard.lateness import Times, lateness
from wmr_ctrl.control.laws.prediction import acts_for, slowed
from wmr_ctrl.world.pose_sensor import corrected, reckoned
from wmr_ctrl.world.references import curves
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3, Ring
from wmr_proofs.paper_functions import target_rate
from wmr_proofs.regions import POSITIVE, Case, target_cases
from wmr_proofs.statement import (
    Relations,
    Statement,
    Symbols,
    between,
    every,
    symbols,
    when,
    within,
)

from .common import LawGraph, barrier_axis
from .guard_axis import DELAYED, GuardAxis
from .guard_sent import only

DECLARED = dict.fromkeys(("ref_radius", "ref_rate", "ref_speed"), POSITIVE)

MOTIONS = ({"kind": "circle", "more": "{DIRECTION}"}, {"kind": "line", "more": ""})
claim = Claims()


@claim("law.mass", (4,), by=Ring())
def believed(mutation: Mutation) -> Statement:
    """the inertia that a law believes in is diag(model.m, model.I).

    This is the M of the entries about laws.

    Given: any values.
    """
    law = LawGraph("mb")
    mass, t = law.own(law.context.mass), law.symbols
    return Statement(t, (mass[0] == mutation * t["model.m"], mass[1] == t["model.I"]))


@claim("eq18.rate", (18, 23), by=Ring(target_cases(edges=False)))
def eq18_rate(mutation: Mutation) -> Statement:
    """v_c1' = (d v_c1/d v_c0) v_c0'.

    Rate of the velocity's target.

    Given: {OFF_EDGES}.
    """
    a, _, c, u1, u2 = barrier_axis()
    t = a | symbols("cdot")
    return Statement(t, target_rate(c, t.cdot, u1, u2) == mutation * gradient(a.x, c) * t.cdot)


@claim("reference.{kind}", by=Ring((Case("rates > 0", declared=DECLARED),)), over=MOTIONS)
def motion(mutation: Mutation, kind: str) -> Statement:
    """{kind}: x_d'^2 + y_d'^2 = v1d^2, x_d' y_d'' - y_d' x_d'' = v1d^2 v2d, theta_d' = v2d, and the
    published rates are the derivatives of v1d and v2d.

    The desired motion is one that the robot could make.

    Given: rates and radius > 0{more}.
    """
    names = {"circle": "t ref_radius ref_rate", "line": "t ref_speed ref_heading x0 y0"}[kind]
    t = symbols(names, names.removeprefix("t "))
    given = {**t, "ref_origin": vertcat(t.x0, t.y0)} if kind == "line" else t
    y = {"circle": curves.circle, "line": curves.line}[kind](t.t, given)
    first = jacobian(y, t.t)
    second = jacobian(first, t.t)
    turned = first[0] * second[1] - first[1] * second[0]
    fast = first[0] ** 2 + first[1] ** 2 == mutation * y[3] ** 2 + (1 - mutation)
    goals: Relations = (fast, turned == y[3] ** 2 * y[4], every(first[2:5], y[4:7]))
    if kind == "line":
        ahead = (first[0] == -sin(y[2]) * y[3], first[1] == cos(y[2]) * y[3])
        goals = goals, ahead, y[3] == t.ref_speed
    return Statement(t, goals)


@claim("estimator.pose", by=Ring())
def estimator_pose(mutation: Mutation) -> Statement:
    """estimate = gain measured + (1 - gain) (old estimate moved by the old velocity).

    Dead reckoning: a whole correction takes the sensor's pose, none keeps moving.

    Given: any values.
    """
    names = "x y theta v omega x_m y_m theta_m period gain"
    t = symbols(names, names)
    pose, old = (vertcat(*(t[n] for n in part.split())) for part in ("x y theta", "v omega"))
    measured, period, gain = vertcat(t.x_m, t.y_m, t.theta_m), t.period, t.gain
    theta = pose[2] + period * old[1]
    moved = pose + period * vertcat(-old[0] * sin(theta), old[0] * cos(theta), old[1])
    estimate = corrected(reckoned(pose, old, period), measured, gain)
    return Statement(t, every(estimate, gain * mutation * measured + (1 - gain) * moved))


MOST = 5
prediction_claim = Claims()


def acting() -> tuple[Symbols, SX, SX, list[SX]]:
    """Symbols, of them the delay and the period, and for how long each command acts."""
    t = symbols("delay period")
    return t, t.delay, t.period, [acts_for(k, t.delay, t.period) for k in range(1, MOST + 1)]


@prediction_claim("prediction.times")
def prediction_times(mutation: Mutation) -> Statement:
    """tau_1 + ... + tau_n = delay, 0 <= tau_j <= T, n = 5.

    The law's prediction uses each command in transit for exactly the time that it acts within the
    delay.

    Given: 0 <= delay <= 5 T; up to 5 commands.
    """
    t, delay, period, times = acting()
    total = reduce(SX.__add__, times)
    each = [between(0, time, period) for time in times]
    return Statement(t, (total == mutation * delay, each), between(0, delay, MOST * period))


@prediction_claim("prediction.order", given=f"delay >= 0, T > 0; j = 1 to {MOST - 1}")
def oldest_first(mutation: Mutation) -> Statement:
    """tau_j = T wherever tau_(j+1) is not 0.

    Only the oldest command in transit acts for less than a period.
    """
    t, delay, period, times = acting()
    goals = [older * (newer - mutation * period) == 0 for newer, older in pairwise(times)]
    return Statement(t, goals, (delay >= 0, period > 0))


@prediction_claim("prediction.friction")
def friction(mutation: Mutation) -> Statement:
    """v+ has the sign of u, |v+| <= |u|, and v+ = u - t F1(u)/M while that is smaller than u.

    In the prediction friction slows the robot down and never reverses it.

    Given: F1(u) u >= 0.
    """
    t = symbols("free taken")
    free, taken = t.free, t.taken
    after = slowed(free, taken)
    slows = after * free >= 0, mutation * abs(free) >= abs(after)
    goals = slows, fmax(abs(free) - abs(taken), 0) * (after - free + taken) == 0
    return Statement(t, goals, taken * free >= 0)


piece_claim = Claims()


@piece_claim("guard.lemma.piece")
def lemma_piece(mutation: Mutation) -> Statement:
    """max(v, f_speed) rises by at most t max(F + dbar - f_min, 0)/M_min over a piece of time t.

    guard.lemma for motions in pieces; its integrals are the limit of these.

    Given: v linear over the piece: friction f, push d and F constant; v on one side of f_speed, f
    >= f_min above it, |d| <= dbar, M >= M_min > 0.
    """
    a, t = GuardAxis(), symbols("end drag push")
    v, end, edge = a.v, t.end, a.f_speed
    sizes = a.mass >= a.M_min, a.t >= 0, within(t.push, a.dbar)
    sides = (v - edge) * (end - edge) >= 0, when(logic_or(v > edge, end > edge), t.drag >= a.f_min)
    given = a.sound(), sizes, sides, a.mass * (end - v) == a.t * (a.asked - t.drag + t.push)
    most = fmax(v, edge) + mutation(1, 0.9) * a.t * push([a.asked], a.bounds, 1) / a.M_min
    return Statement(a | t, most >= fmax(end, edge), given)


@piece_claim("guard.delay.step")
def delay_step(mutation: Mutation) -> Statement:
    """v+ is at most y + nbar or f_speed, plus the contributions of earlier commands.  The next
    command adds at most tau max(F + net, 0)/M_min, as in the guard's sum.  The same holds for -v.

    One step of the sum over commands in transit, for any earlier sum.

    Given: guard.lemma over the piece; it acts for 0 <= s <= tau, M >= M_min > 0.
    """
    a = GuardAxis(DELAYED)
    more, goals = only(a), []
    for way, sum_of in ((1, more.ahead), (-1, more.back)):
        most = fmax(way * a.y + a.nbar, a.f_speed) + a("", way)
        gained = a.since * fmax(way * a.sent + a.net, 0) / a.mass
        reached = fmin(a.arrived, most) + gained
        goals.append(most + mutation(1, 0.9) * sum_of >= reached)
    given = a.sound(), a.mass >= a.M_min, between(0, a.since, a.periods * a.period)
    return Statement(a, goals, given)


@piece_claim("guard.late.mean-piece")
def mean_piece(mutation: Mutation) -> Statement:
    """v+ now is at most the guard's bound from y with the commands of both periods, in the mean and
    from rest; likewise -v.

    guard.late.mean for motions in pieces; its integrals are the limit of these.

    Given: a window of two periods, v linear in each: y is (v_0 + 2 v_1 + v_2)/4 to within nbar;
    guard.lemma over each period.
    """
    a, t = GuardAxis(DELAYED), symbols("v0 v1 v2")
    b, v = a.bounds, [*t.values()]
    late = lateness(Times(period=1.0, step=1.0, window=2.0))
    sent = [vertcat(a[name], 0) for name in ("sent", "other")]
    coming = delayed_push(sent, late, 0, b, Tails("tail", (late, late)))
    assert coming is not None
    mean = (v[0] + mutation(2, 1.5) * v[1] + v[2]) / 4
    goals, given = [], [a.sound(), within(a.y - mean, b.nbar)]
    for way, seen in ((1, coming), (-1, coming.mirrored)):
        speeds = [fmax(way * item, b.f_speed) for item in v]
        for k, name in enumerate(("other", "sent")):
            gain = b.period * fmax(way * a[name] + a.net, 0) / b.M_min
            given.append(speeds[k] + gain >= speeds[k + 1])
        goals.append(seen.reached(fmax(way * a.y + b.nbar, b.f_speed), b) >= speeds[2])
    return Statement(a | t, goals, given)


@piece_claim("guard.late.convex")
def convex(mutation: Mutation) -> Statement:
    """p(w F + (1 - w) F') <= w p(F) + (1 - w) p(F'), with p the push that the guard assumes for a
    force; in both directions.

    Jensen's inequality of two forces, and so of any weights on finitely many.

    Given: 0 <= w <= 1; any two forces, any dbar - f_min.
    """
    a, w = GuardAxis(DELAYED), SX.sym("w")
    forces, goals = (a.sent, a.other), []
    for way in (1, -1):
        mixed, first, second = (
            push([force], a.bounds, way) for force in (w * forces[0] + (1 - w) * forces[1], *forces)
        )
        goals.append(w * first + mutation(1 - w, w) * second >= mixed)
    return Statement(a | {"w": w}, goals, between(0, w, 1))


def vanishes(value: SX, t: SX, where: float) -> Relations:
    """The value is 0 at one point."""
    return substitute(value, t, SX(where)) == 0


@piece_claim("lemma.log", (15,), by=Z3(), premises="lemma.integration")
def logarithm(mutation: Mutation) -> Statement:
    """ln t <= t - 1: the difference is 0 at t = 1, and its derivative has the sign of t - 1.

    The one fact about the logarithm that the exact algebra uses.

    Given: t > 0.
    """
    t = SX.sym("t")
    gap = t - 1 - mutation(1, 2) * log(t)
    goals = vanishes(gap, t, 1), gradient(gap, t) * (t - 1) >= 0
    return Statement({"t": t}, goals, t > 0)


@piece_claim("lemma.sine", (40, 46, 55), by=Z3(), premises="lemma.integration")
def sine(mutation: Mutation) -> Statement:
    """|sin t| <= |t|, 1 - cos t <= t^2/2, and |sin t| >= (2/pi) |t| for |t| <= pi/2: t - sin t is
    odd and does not fall; t^2/2 - 1 + cos t has the derivative t - sin t; (sin t)/t has the
    derivative n/t^2, n = t cos t - sin t, and n does not rise from 0 on; each is 0 at 0.

    Facts about the angle in the window argument.

    Given: sin t >= 0 for 0 <= t <= pi.
    """
    names = symbols("t")
    t = names.t
    gap, rise = t - sin(t), t**2 / 2 - 1 + cos(t)
    slope = t * cos(t) - sin(t)
    at_0 = [vanishes(value, t, 0) for value in (gap, rise, slope)]
    rates = gradient(rise, t) == gap, t**2 * gradient(sin(t) / t, t) == mutation * slope
    goals = at_0, gradient(gap, t) >= 0, rates, -gradient(slope, t) >= 0
    return Statement(names, goals, (t > 0, sin(t) >= 0))
