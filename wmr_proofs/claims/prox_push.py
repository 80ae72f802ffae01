"""The sampled-data law on its own graph: the effect of a push on a sample, and its decay; with
a wrong mass and a constant target, the limit of the loop.

v+, friction and the observer's force are free numbers with the properties that other entries prove.
"""

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property

from casadi import DM, SX, exp, expm1, fmax, horzcat, logic_and, substitute, vertcat, vertsplit

from wmr_ctrl.control.laws.prox import next_velocity, prox_step
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Cuts,
    Named,
    Relations,
    Statement,
    equal,
    every,
    positive,
    symbols,
    when,
    within,
)

from .common import BOTH_AXES, VELOCITY_NAMES, LawGraph, named_axes


class Sampled(Named):
    """One axis of the law's graph, with v+, friction and exp(-wo T) - 1 as free numbers.

    ``free``: v+, friction there, the observer's force, exp(-wo T) - 1, friction between samples;
    ``old``, ``f_old``: the previous measurement and the observer's previous force; ``mass`` is the
    believed one, ``force`` the law's, ``numbers`` that T and M are positive.
    """

    def __init__(self, axis: int) -> None:
        self.axis, self.law = axis, LawGraph("prox")
        t = self.law.symbols
        self.free = symbols("next friction f fall drag")
        self.symbols = t | self.free
        self.period, self.v = t["clock.control"], t[VELOCITY_NAMES[axis]]
        self.old, self.f_old = t[f"v_previous[{axis + 1}]"], t[f"f_hat[{axis + 1}]"]
        self.mass = self.law.own(self.law.context.mass)[axis]
        self.force, self.numbers = self.law.force[axis], positive(self.period, self.mass)

    @cached_property
    def force_cuts(self) -> Cuts:
        """v+, the friction there, and the observer's force."""
        law, step = self.law, next_velocity(self.law.context)
        both = law.own(vertcat(step, law.context.friction_at(step)))
        k = self.axis
        return {"next": both[k], "friction": both[2 + k], "f": law.system.update[k]}

    def moved(self, push: SX) -> SX:
        """v + T (F - F1(v+) + push)/M."""
        force = self.force - self.force_cuts["friction"] + push
        return self.v + self.period * force / self.mass

    @property
    def applied(self) -> SX:
        """The force that acted since the previous sample."""
        t = self.law.symbols
        torque = vertcat(t["tau_applied[1]"], t["tau_applied[2]"])
        return wheel_to_force(t["robot.r"], t["robot.l"], torque)[self.axis]

    @cached_property
    def observer_cuts(self) -> Cuts:
        """exp(-wo T) - 1, and the friction at the middle velocity."""
        law, t = self.law, self.law.symbols
        middle = 0.5 * (law.own(law.context.v) + vertcat(t["v_previous[1]"], t["v_previous[2]"]))
        return {
            "fall": expm1(-t["gains.prox.wo"] * self.period),
            "drag": law.own(law.context.friction_at(middle))[self.axis],
        }

    @property
    def observed(self) -> Relations:
        """T, M, r, l > 0, after the first sample, 0 < exp(-wo T) < 1."""
        t, fall = self.law.symbols, self.free.fall
        return self.numbers, positive(t.started, t["robot.r"], t["robot.l"]), fall > -1, fall < 0

    def gained(self, d: SX) -> Relations:
        """M (v - v_old) = T (F - F1 + d) since the previous sample."""
        pushed = self.applied - self.observer_cuts["drag"] + d
        return self.mass * (self.v - self.old) == self.period * pushed


claim = Claims()


@claim("prox.assembled", each={name: {"transport": name} for name in ("two-part", "level")})
def assembled(mutation: Mutation, transport: str) -> Statement:
    """on the law's graph v+ = X_(1-E)(E v* + (1-E) c+) with E = exp(-rho T/2), c+ = c + T c' and v*
    carried from c to c_m, both axes: c_m = c + T c'_d with two-part transport, c + T c' with level
    transport.

    The law's step is the one in the entries prox.*, with the same rates and targets.

    Given: any pose, velocity, reference and parameters; c' and c'_d the rate of v_c0 and its part
    by the reference's acceleration.
    """
    law = LawGraph("prox", ("gains.prox.transport", transport))
    t, context = law.symbols, law.context
    inner = context.v_c0, context.v_c0_dot, context.v_c0_dot_reference
    T, steps = t["clock.control"], []
    for axis, name in enumerate(VELOCITY_NAMES):
        c, rate, along = (law.own(item)[axis] for item in inner)
        half = -0.5 * t[f"gains.prox.rho[{axis + 1}]"] * T
        way = c, c + T * (rate if transport == "level" else along), c + T * rate
        limits = t[f"limits.v_u1[{axis + 1}]"], t[f"limits.v_u2[{axis + 1}]"]
        shares = exp(half), -expm1(half)
        steps.append(prox_step(t[name], way, shares, limits, context.smooth))
    free = symbols("step1 step2")
    goals = every(law.own(next_velocity(context)), mutation * vertcat(*steps))
    return Statement(t | free, goals, cuts=dict(zip(free, steps, strict=True)))


@claim("prox.force", each=BOTH_AXES)
def force(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph v + T (F - F1(v+) - f)/M = v+, on each axis.

    With an exact model the law's force reaches its intended velocity in one period; f is the
    observer's force.

    Given: T, M > 0; F1(v+) and v+ whatever they are.
    """
    s = Sampled(axis)
    goal = s.moved(-mutation * s.free.f) == s.free.next
    return s.states(goal, given=s.numbers, cuts=s.force_cuts)


@claim("prox.pushed", premises="prox.contracts prox.not-expansive", each=BOTH_AXES)
def pushed(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, for M v' = F - F1(v+) + d over a period: |w+| <= E (|w| + |c+ - c_m|) + T
    |f + d|/M + |eps|, on each axis.

    The effect of a push in one sample, at every speed: the part that the observer does not
    compensate, over the mass.  At no speed is a push stronger than the law.

    Given: as prox.contracts; T, M > 0, mass right; w+ the distance to the actual target, c+ + eps.
    """
    s = Sampled(axis)
    t = symbols("d w way x_next x_real eps E")
    d, w, way, x_next, x_real, eps, E = t.values()
    nearest = E * (w + way) >= abs(s.free.next - x_next)
    moved = abs(eps) >= abs(x_real - x_next)
    push = s.period * abs(d + s.free.f) / s.mass
    most = E * (w + way) + mutation(push, 0.9 * push) + abs(eps)
    goal = most >= abs(s.moved(d) - x_real)
    return s.states(goal, given=(s.numbers, nearest, moved), cuts=s.force_cuts, more=t)


@claim("prox.limit", premises="prox.margin transport.inside lemma.sampling", each=BOTH_AXES)
def limit(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, mass right, no guard, torque not limited: from |v| <= v_u1, |c+| <= C to
    |v| <= v_u1 at the next sample, on each axis.

    The limits that the law keeps without a guard; the guard keeps them under weaker conditions.

    Given: T, M > 0; |v+| <= v_u1 - m (prox.margin), |T (f + d)/M| <= m, F1(v+) as believed.
    """
    s, t = Sampled(axis), symbols("d m")
    u1 = s.law[f"limits.v_u1[{axis + 1}]"]
    room = u1 - t.m >= abs(s.free.next)
    push = t.m >= abs(s.period * (s.free.f + t.d) / s.mass)
    goal = mutation(1, 0.9) * u1 >= abs(s.moved(t.d))
    return s.states(goal, given=(s.numbers, room, push), cuts=s.force_cuts, more=t)


def falls(after: SX, before: SX, to: SX, share: SX) -> Relations:
    """Goal: the excess of a size over ``to`` shrinks to at most a share of itself."""
    return share * fmax(before - to, 0) >= fmax(after - to, 0)


@claim("prox.gain.step", premises="prox.contracts", each=BOTH_AXES)
def gain_step(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph: max(|w+| - W, 0) <= E max(|w| - W, 0), on each axis.

    One term of the series in prox.gain.

    Given: T, M > 0, 0 < E < 1; |v+ - x+| <= E (|w| + r) (prox.contracts), |f + d| <= p, the
    target's next value off by at most eps; W (1 - E) = T p/M + eps + E r.
    """
    s, t = Sampled(axis), symbols("d w way x_next x_real eps E p W")
    d, w, way, x_next, x_real, eps, E, p, W = t.values()
    whole = s.period * p / s.mass + eps + E * way
    nearest = E * (w + way) >= abs(s.free.next - x_next)
    off = within(x_real - x_next, eps), within(s.free.f + d, p)
    sums_up = equal(W * (1 - E), mutation(1, 0.9) * whole)
    given = s.numbers, E > 0, E < 1, w >= 0, nearest, off, sums_up
    goal = falls(abs(s.moved(d) - x_real), w, W, E)
    return s.states(goal, given=given, cuts=s.force_cuts, more=t)


@claim("prox.gain.observer", each=BOTH_AXES)
def gain_observer(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, L = 1 - exp(-wo T): max(|f + d| - P, 0) <= (1 - L) max(|f_old + d_old| -
    P, 0), on each axis.

    One term of the observer's series in prox.gain.

    Given: as prox.observer; |d - d_old| <= L P.
    """
    s, t = Sampled(axis), symbols("d d_old P")
    slow = within(t.d - t.d_old, mutation(1, 1.1) * -s.free.fall * t.P)
    goal = falls(abs(s.law.system.update[axis] + t.d), abs(s.f_old + t.d_old), t.P, 1 + s.free.fall)
    given = s.observed, s.gained(t.d_old), slow
    return s.states(goal, given=given, cuts=s.observer_cuts, more=t)


@claim("prox.observer-first")
def observer_first(mutation: Mutation) -> Statement:
    """on the law's graph f = 0 at the first sample, and its velocity is the old one at the next
    sample, when the observer has started; both axes.

    From the next sample on prox.observer holds; the first command compensates no push.

    Given: the state that the law starts from; any first sample.
    """
    law = LawGraph("prox")
    later = substitute(law.system.update, law.system.x, DM(law.system.x0))
    v = vertcat(*(law[name] for name in VELOCITY_NAMES))
    return Statement(law, every(later[:5], vertcat(0, 0, v, mutation(1, 0))))


@claim("prox.observer", each=BOTH_AXES)
def observer(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph f + d = exp(-wo T) (f_old + d_old) + d - d_old, on each axis.

    The observer compensates a push at the rate wo; the remainder is due to the push's changes.

    Given: after the first sample; T, M, r, l, wo > 0; M (v - v_old)/T = F_applied - F1 + d_old with
    the believed M and F1 at the middle velocity; d acts from now on.
    """
    s, t = Sampled(axis), symbols("d d_old")
    left = (1 + mutation * s.free.fall) * (s.f_old + t.d_old) + t.d - t.d_old
    goal = s.law.system.update[axis] + t.d == left
    given = s.observed, s.gained(t.d_old)
    return s.states(goal, given=given, cuts=s.observer_cuts, more=t)


@claim("prox.observer-bound", each=BOTH_AXES)
def observer_bound(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, with L = 1 - exp(-wo T): |d_old|, |f_old| <= D imply |f| <= D; L |f_old +
    d_old|, |d - d_old| <= D imply L |f + d| <= D, on each axis.

    The observer's error is at most 2 sup |d|, and at most the largest change of d from sample to
    sample over L.

    Given: as prox.observer; 0 < exp(-wo T) < 1.
    """
    s, t = Sampled(axis), symbols("d d_old most change")
    d, d_old, most, change = t.values()
    share, f = -s.free.fall, s.law.system.update[axis]
    tight = mutation(1, 0.9)
    slow = logic_and(abs(d - d_old) <= change, share * abs(s.f_old + d_old) <= change)
    small = when(logic_and(abs(d_old) <= most, abs(s.f_old) <= most), tight * most >= abs(f))
    goals = small, when(slow, tight * change >= share * abs(f + d))
    given = s.observed, s.gained(d_old)
    return s.states(goals, given=given, cuts=s.observer_cuts, more=t)


def _matrix(mu: SX, a: SX, share: SX) -> SX:
    """The loop of (w, T f/M^)."""
    return vertcat(horzcat(1 - mu * a, mu), horzcat(-share * a * (1 - mu), 1 - share * mu))


FAST = {"L": "0.3", "least": "1/4", "p": "1/6", "s": "53/5", "g": "0.93"}
GENTLE = {"L": "0.07", "least": "1/10", "p": "1/5", "s": "60", "g": "0.993"}

LOOP = "prox.loop-force prox.loop-observer prox.loop-observer-angular"
mass_claim = Claims()


@mass_claim("prox.loop-force", each=BOTH_AXES)
def loop_force(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, mass M = M^/mu: w+ = (1 - mu a) w + mu q, q = T f/M^, on each axis.

    How a wrong mass changes the step.

    Given: T, M^ > 0; target held, v+ = v - a w; no disturbance, F1(v+) compensated.
    """
    s, t = Sampled(axis), symbols("mu a x")
    w, q = s.v - t.x, s.period * s.free.f / s.mass
    moves = s.period * t.mu * (s.force - s.force_cuts["friction"]) / s.mass
    goal = w + moves == (1 - t.mu * t.a) * w + mutation * t.mu * q
    given = positive(s.period, s.mass), s.free.next == s.v - t.a * w
    return s.states(goal, given=given, cuts=s.force_cuts, more=t)


@mass_claim("prox.loop-observer{of}", over=named_axes())
def loop_observer(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, mass M = M^/mu: q+ = (1 - L mu) q - L a (1 - mu) w, {where} axis.

    How a wrong mass changes the observer.

    Given: as prox.loop-force, one sample later; F1 between the samples compensated.
    """
    s, t = Sampled(axis), symbols("mu a w")
    share, q = -s.free.fall, s.period * s.f_old / s.mass
    asked = s.mass * (-t.a * t.w) / s.period + s.f_old
    moved = s.mass * (s.v - s.old) == t.mu * s.period * asked
    given = s.applied - s.observer_cuts["drag"] == asked, moved
    left = (1 - share * t.mu) * q - mutation * share * t.a * (1 - t.mu) * t.w
    goal = s.period * s.law.system.update[axis] / s.mass == left
    return s.states(goal, given=(s.observed, given), cuts=s.observer_cuts, more=t)


@mass_claim("prox.jury", premises=LOOP)
def jury(mutation: Mutation) -> Statement:
    """velocity loop with observer: 1 + tr + det = 4 - mu (2 (a + L) - a L), 1 - tr + det = mu a L.

    The two numbers that decide the sampled loop's stability.

    Given: mu = M^/M, L = 1 - exp(-wo T), v+ = v - a w: a = 1 - E below v_u2 with the target held; c
    held.
    """
    t = symbols("mu a L")
    mu, a, L = t.values()
    loop = _matrix(mu, a, L)
    trace, det = loop[0, 0] + loop[1, 1], loop[0, 0] * loop[1, 1] - loop[0, 1] * loop[1, 0]
    edge = 4 - mu * (2 * (a + L) - mutation * a * L)
    return Statement(t, (1 + trace + det == edge, 1 - trace + det == mu * a * L))


@mass_claim("prox.light-model", premises="prox.jury")
def light_model(mutation: Mutation) -> Statement:
    """M^ <= (4/3) M makes the velocity loop stable for every rho, T and wo.

    If in doubt, state a mass that is too small rather than too large.  This is for a constant
    target: in the tracking loop a is larger (a = (1 - E)(1 + T k1) on the linear axis); `check` has
    the limits of that loop.

    Given: 0 < a, L < 1.
    """
    t = symbols("mu a L")
    mu, a, L = t.values()
    given = [part for name in ("a", "L") for part in (t[name] > 0, t[name] < 1)]
    edge = 4 - mu * (2 * (a + L) - a * L)
    det = 1 - mu * (a + L) + mu * a * L
    return Statement(t, (edge > 0, det < 1), (given, mu > 0, mutation(4 / SX(3), SX(1.5)) >= mu))


@mass_claim(
    "prox.wrong-mass",
    premises=LOOP,
    each={"quick": {"numbers": FAST}, "gentle": {"numbers": GENTLE}},
)
def wrong_mass(mutation: Mutation, numbers: Mapping[str, str]) -> Statement:
    """w^2 + 2 p w q + s q^2 falls by g^2 in a sample for every mu in [5/8, 5/3] and every a from
    a_min to 1, and is at least (w^2 + q^2)/2: for L = 0.3 with a_min = 1/4, p = 1/6, s = 53/5, g =
    0.93; for L = 0.07 with a_min = 1/10, p = 1/5, s = 60, g = 0.993.

    With a believed mass that is wrong by that much, nothing grows.

    Given: target held, M/M^ anywhere in [3/5, 8/5] and another one in each sample; no disturbance.
    """
    t = symbols("w q mu a " + " ".join(numbers))
    p, s = t.p, t.s
    w, q = vertsplit(_matrix(t.mu, t.a, t.L) @ vertcat(t.w, t.q))
    form = t.w**2 + 2 * p * t.w * t.q + s * t.q**2
    shares = {name: Fraction(value) for name, value in numbers.items()}
    exact = [x.denominator * t[name] == x.numerator for name, x in shares.items()]
    sides = (8 * t.mu - 5) * (3 * t.mu - 5), (t.a - t.least) * (t.a - 1)
    goals = (
        mutation(1, 0.9) * t.g**2 * form >= w**2 + 2 * p * w * q + s * q**2,
        form >= 0.5 * (t.w**2 + t.q**2),
    )
    return Statement(t, goals, (exact, [-side >= 0 for side in sides]))
