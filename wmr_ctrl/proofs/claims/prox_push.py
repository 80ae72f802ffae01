"""The sampled-data law on its own graph: what a push does to a sample, and what is left of it.

v+, friction and the observer's force stand as free numbers with what other entries say of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any

import casadi as ca

from wmr_ctrl.laws.prox import next_velocity, prox_step
from wmr_ctrl.model.dynamics import wheel_to_force
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.common import VELOCITY_NAMES, LawGraph
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import (
    Relation,
    Statement,
    above,
    at_least,
    equal,
    every,
    symbols,
)

AXES = ({"of": "", "where": "linear", "axis": 0}, {"of": "-angular", "where": "angular", "axis": 1})


class Sampled:
    """One axis of the law's graph, with v+, friction and exp(-wo T) - 1 as free numbers.

    ``free``: v+, friction there, the observer's force, exp(-wo T) - 1, friction between samples;
    ``old``, ``f_old``: the previous measurement and the observer's previous force.
    """

    def __init__(self, axis: int) -> None:
        self.axis, self.law = axis, LawGraph("prox")
        t = self.law.symbols
        self.free = symbols("next friction f fall drag")
        self.period, self.v = t["clock.control"], t[VELOCITY_NAMES[axis]]
        self.old, self.f_old = t[f"v_previous[{axis + 1}]"], t[f"f_hat[{axis + 1}]"]

    @property
    def mass(self) -> ca.SX:
        """Believed mass."""
        return self.law.own(self.law.context.mass)[self.axis]

    @property
    def force(self) -> ca.SX:
        """Force of the law."""
        return self.law.force[self.axis]

    @cached_property
    def force_cuts(self) -> dict[str, ca.SX]:
        """v+, the friction there, and the observer's force."""
        law, step = self.law, next_velocity(self.law.context)
        both = law.own(ca.vertcat(step, law.context.friction_at(step)))
        return {
            "next": both[self.axis],
            "friction": both[2 + self.axis],
            "f": law.system.update[self.axis],
        }

    @property
    def applied(self) -> ca.SX:
        """The force that acted since the previous sample."""
        t = self.law.symbols
        torque = ca.vertcat(t["tau_applied[1]"], t["tau_applied[2]"])
        return wheel_to_force(t["robot.r"], t["robot.l"], torque)[self.axis]

    @cached_property
    def observer_cuts(self) -> dict[str, ca.SX]:
        """exp(-wo T) - 1, and the friction at the middle velocity."""
        law, t = self.law, self.law.symbols
        old = ca.vertcat(t["v_previous[1]"], t["v_previous[2]"])
        middle = 0.5 * (law.own(law.context.v) + old)
        return {
            "fall": ca.expm1(-t["gains.prox.wo"] * self.period),
            "drag": law.own(law.context.friction_at(middle))[self.axis],
        }

    @property
    def observed(self) -> tuple[Relation, ...]:
        """T, M, r, l > 0, after the first sample, 0 < exp(-wo T) < 1."""
        t, fall = self.law.symbols, self.free["fall"]
        numbers = (self.period, self.mass, t["started"], t["robot.r"], t["robot.l"])
        return (*map(above, numbers), above(fall, -1), above(0, fall))

    def gained(self, d: ca.SX) -> Relation:
        """M (v - v_old) = T (F - F1 + d) since the previous sample."""
        pushed = self.applied - self.observer_cuts["drag"] + d
        return equal(self.mass * (self.v - self.old), self.period * pushed)

    def states(
        self,
        goals: tuple[Relation, ...],
        given: tuple[Relation, ...],
        cuts: dict[str, ca.SX],
        more: dict[str, ca.SX],
    ) -> Statement:
        """The statement on the law's graph."""
        kept = {name: x for name, x in self.free.items() if name in cuts}
        return Statement({**self.law.symbols, **kept, **more}, goals, given, cuts)


claim = Claims(by=Z3(effort=150))


@claim(
    "prox.assembled{part}",
    given="any pose, velocity, reference and parameters; c' and c'_d the rate of v_c0 and its part "
    "by the reference's acceleration",
    over=({"part": "", "moved": "c'_d"}, {"part": "-level", "moved": "c'"}),
)
def assembled(mutation: Mutation, part: str) -> Statement:
    """on the law's graph v+ = X_(1-E)(E v* + (1-E) c+) with E = exp(-rho T/2), c+ = c + T c' and v*
    carried from c to c_m = c + T {moved}, both axes.

    The step that the law takes is the one that the entries prox.* speak of, with rates and targets
    as they are there.
    """
    law = LawGraph("prox", (("gains.prox.transport", "level"),) if part else ())
    t, context = law.symbols, law.context
    inner = context.v_c0, context.v_c0_dot, context.v_c0_dot_reference
    T, steps = t["clock.control"], []
    for axis, name in enumerate(VELOCITY_NAMES):
        c, rate, along = (law.own(item)[axis] for item in inner)
        half = -0.5 * t[f"gains.prox.rho[{axis + 1}]"] * T
        way = c, c + T * (rate if part else along), c + T * rate
        limits = t[f"limits.v_u1[{axis + 1}]"], t[f"limits.v_u2[{axis + 1}]"]
        shares = ca.exp(half), -ca.expm1(half)
        steps.append(prox_step(t[name], way, shares, limits, context.smooth))
    free = symbols("step1 step2")
    goals = every(law.own(next_velocity(context)), mutation * ca.vertcat(*steps))
    return Statement({**t, **free}, goals, cuts=dict(zip(free, steps, strict=True)))


@claim("prox.force{of}", given="T, M > 0; F1(v+) and v+ whatever they are", over=AXES)
def force(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph v + T (F - F1(v+) - f)/M = v+, {where} axis.

    With the model exact the law's force leads to the velocity that it aims at in one period; f is
    what the observer adds.
    """
    s = Sampled(axis)
    pushed = s.force - s.force_cuts["friction"] - mutation * s.free["f"]
    end = s.v + s.period * pushed / s.mass
    given = (above(s.period), above(s.mass))
    return s.states((equal(end, s.free["next"]),), given, s.force_cuts, {})


@claim(
    "prox.pushed{of}",
    given="T, M > 0, mass right; w+ to the target as it comes out, c+ + eps",
    premises="prox.contracts prox.contracts-smooth prox.not-expansive",
    over=AXES,
)
def pushed(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, for M v' = F - F1(v+) + d over a period: |w+| <= E (|w| + |c+ - c_m|) + T
    |f + d|/M + |eps|, {where} axis.

    What a push costs in one sample, at every speed: its part that the observer does not make up
    for, over the mass. There is no speed from which a push is stronger than the law.
    """
    s = Sampled(axis)
    t = symbols("d w way x_next x_real eps E")
    nearest = at_least(t["E"] * (t["w"] + t["way"]), ca.fabs(s.free["next"] - t["x_next"]))
    moved = at_least(ca.fabs(t["eps"]), ca.fabs(t["x_real"] - t["x_next"]))
    end = s.v + s.period * (s.force - s.force_cuts["friction"] + t["d"]) / s.mass
    push = s.period * ca.fabs(t["d"] + s.free["f"]) / s.mass
    most = t["E"] * (t["w"] + t["way"]) + mutation(push, 0.9 * push) + ca.fabs(t["eps"])
    given = (above(s.period), above(s.mass), nearest, moved)
    return s.states((at_least(most, ca.fabs(end - t["x_real"])),), given, s.force_cuts, t)


@claim(
    "prox.observer{of}",
    given="after the first sample; M (v - v_old)/T = F_applied - F1 + d_old with the believed M "
    "and F1 at the middle velocity; d acts from now on",
    over=AXES,
)
def observer(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph f + d = exp(-wo T) (f_old + d_old) + d - d_old, {where} axis.

    A push is made up for at the rate wo; what is left comes from its changes.
    """
    s, t = Sampled(axis), symbols("d d_old")
    left = (1 + mutation * s.free["fall"]) * (s.f_old + t["d_old"]) + t["d"] - t["d_old"]
    goal = equal(s.law.system.update[axis] + t["d"], left)
    return s.states((goal,), (*s.observed, s.gained(t["d_old"])), s.observer_cuts, t)


@claim("prox.observer-bound{of}", given="as prox.observer; 0 < exp(-wo T) < 1", over=AXES)
def observer_bound(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, with L = 1 - exp(-wo T): |d_old|, |f_old| <= D imply |f| <= D; L |f_old +
    d_old|, |d - d_old| <= D imply L |f + d| <= D, {where} axis.

    What the observer leaves over is at most 2 sup |d|, and at most the largest change of d from
    sample to sample over L.
    """
    s, t = Sampled(axis), symbols("d d_old most change")
    share, f = -s.free["fall"], s.law.system.update[axis]
    old, new = s.f_old + t["d_old"], f + t["d"]
    tight = mutation(1, 0.9)
    within = ca.logic_and(ca.fabs(t["d_old"]) <= t["most"], ca.fabs(s.f_old) <= t["most"])
    slow = ca.logic_and(
        ca.fabs(t["d"] - t["d_old"]) <= t["change"], share * ca.fabs(old) <= t["change"]
    )
    goals = (
        Relation(ca.if_else(within, tight * t["most"] - ca.fabs(f), 0), ">="),
        Relation(ca.if_else(slow, tight * t["change"] - share * ca.fabs(new), 0), ">="),
    )
    return s.states(goals, (*s.observed, s.gained(t["d_old"])), s.observer_cuts, t)


def _matrix(mu: ca.SX, a: ca.SX, share: ca.SX) -> ca.SX:
    """The loop of (w, T f/M^)."""
    return ca.vertcat(ca.horzcat(1 - mu * a, mu), ca.horzcat(-share * a * (1 - mu), 1 - share * mu))


FAST = {"L": "0.3", "least": "1/4", "p": "1/6", "s": "53/5", "g": "0.93"}
GENTLE = {"L": "0.07", "least": "1/10", "p": "1/5", "s": "60", "g": "0.993"}
MASSES = "target held, M/M^ anywhere in [3/5, 8/5] and another one in each sample"
LOOP = "prox.loop-force prox.loop-force-angular prox.loop-observer prox.loop-observer-angular"
BELIEFS: tuple[dict[str, Any], ...] = (
    {"key": "", "numbers": FAST},
    {"key": "-gentle", "numbers": GENTLE},
)
wrong_mass_claim = Claims(by=Z3(effort=150))


@wrong_mass_claim(
    "prox.loop-force{of}",
    given="T, M^ > 0; target held, v+ = v - a w; no disturbance, F1(v+) compensated",
    over=AXES,
)
def loop_force(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, mass M = M^/mu: w+ = (1 - mu a) w + mu q, q = T f/M^, {where} axis.

    What a wrong mass makes of the step.
    """
    s, t = Sampled(axis), symbols("mu a x")
    w, q = s.v - t["x"], s.period * s.free["f"] / s.mass
    moves = s.period * t["mu"] * (s.force - s.force_cuts["friction"]) / s.mass
    goal = equal(w + moves, (1 - t["mu"] * t["a"]) * w + mutation * t["mu"] * q)
    given = (above(s.period), above(s.mass), equal(s.free["next"], s.v - t["a"] * w))
    return s.states((goal,), given, s.force_cuts, t)


@wrong_mass_claim(
    "prox.loop-observer{of}",
    given="as prox.loop-force, one sample later; F1 between the samples compensated",
    over=AXES,
)
def loop_observer(mutation: Mutation, axis: int) -> Statement:
    """on the law's graph, mass M = M^/mu: q+ = (1 - L mu) q - L a (1 - mu) w, {where} axis.

    What a wrong mass makes of the observer.
    """
    s, t = Sampled(axis), symbols("mu a w")
    share, q = -s.free["fall"], s.period * s.f_old / s.mass
    asked = s.mass * (-t["a"] * t["w"]) / s.period + s.f_old
    given = (
        equal(s.applied - s.observer_cuts["drag"], asked),
        equal(s.mass * (s.v - s.old), t["mu"] * s.period * asked),
    )
    left = (1 - share * t["mu"]) * q - mutation * share * t["a"] * (1 - t["mu"]) * t["w"]
    goal = equal(s.period * s.law.system.update[axis] / s.mass, left)
    return s.states((goal,), (*s.observed, *given), s.observer_cuts, t)


@wrong_mass_claim(
    "prox.jury",
    given="mu = M^/M, L = 1 - exp(-wo T), v+ = v - a w: a = 1 - E below v_u2 with the target "
    "held; c held",
    premises=LOOP,
)
def jury(mutation: Mutation) -> Statement:
    """velocity loop with observer: 1 + tr + det = 4 - mu (2 (a + L) - a L), 1 - tr + det = mu a L.

    The two numbers that decide the sampled loop's stability.
    """
    t = symbols("mu a L")
    loop = _matrix(t["mu"], t["a"], t["L"])
    trace, det = loop[0, 0] + loop[1, 1], loop[0, 0] * loop[1, 1] - loop[0, 1] * loop[1, 0]
    edge = 4 - t["mu"] * (2 * (t["a"] + t["L"]) - mutation * t["a"] * t["L"])
    return Statement(
        t, (equal(1 + trace + det, edge), equal(1 - trace + det, t["mu"] * t["a"] * t["L"]))
    )


@wrong_mass_claim("prox.light-model", given="0 < a, L < 1", premises="prox.jury")
def light_model(mutation: Mutation) -> Statement:
    """M^ <= (4/3) M makes the velocity loop stable for every rho, T and wo.

    Believe a mass that is rather too small. This is about a target that is held: the tracking loop
    makes a larger (a = (1 - E)(1 + T k1) on the linear axis), and `check` has its limits.
    """
    t = symbols("mu a L")
    given = [part for name in ("a", "L") for part in (above(t[name]), above(ca.SX(1), t[name]))]
    share = mutation(4 / ca.SX(3), ca.SX(1.5))
    edge = 4 - t["mu"] * (2 * (t["a"] + t["L"]) - t["a"] * t["L"])
    det = 1 - t["mu"] * (t["a"] + t["L"]) + t["mu"] * t["a"] * t["L"]
    return Statement(
        t, (above(edge), above(ca.SX(1), det)), (*given, above(t["mu"]), at_least(share, t["mu"]))
    )


@wrong_mass_claim(
    "prox.any-mass.step{key}",
    given=f"{MASSES}; no disturbance",
    premises=LOOP,
    wording="w^2 + 2 p w q + s q^2 falls by g^2 in a sample for every mu in [5/8, 5/3] and every a "
    "in [{numbers[least]}, 1], and is at least (w^2 + q^2)/2; L, p, s and g as in "
    "prox.wrong-mass{key}",
    over=tuple(table | {"corners": False} for table in BELIEFS),
)
@wrong_mass_claim(
    "prox.wrong-mass{key}",
    given=f"{MASSES}: at its corners; no disturbance",
    premises=LOOP,
    over=BELIEFS,
)
def wrong_mass(mutation: Mutation, numbers: Mapping[str, str], corners: bool = True) -> Statement:
    """w^2 + 2 p w q + s q^2 falls by g^2 in a sample at the four corners mu in {{5/8, 5/3}}, a in
    {{{numbers[least]}, 1}}: L = {numbers[L]}, p = {numbers[p]}, s = {numbers[s]}, g = {numbers[g]}.

    A mass believed wrong by that much makes nothing grow.
    """
    t = symbols("w q mu a " + " ".join(numbers))
    p, s = t["p"], t["s"]
    w, q = ca.vertsplit(_matrix(t["mu"], t["a"], t["L"]) @ ca.vertcat(t["w"], t["q"]))
    form = t["w"] ** 2 + 2 * p * t["w"] * t["q"] + s * t["q"] ** 2
    left = t["g"] ** 2 * form
    shares = {name: Fraction(value) for name, value in numbers.items()}
    exact = [equal(x.denominator * t[name], x.numerator) for name, x in shares.items()]
    sides = (8 * t["mu"] - 5) * (3 * t["mu"] - 5), (t["a"] - t["least"]) * (t["a"] - 1)
    within = [equal(side) if corners else at_least(-side) for side in sides]
    goal = at_least(mutation(1, 0.9) * left, w**2 + 2 * p * w * q + s * q**2)
    positive = () if corners else (at_least(form, 0.5 * (t["w"] ** 2 + t["q"] ** 2)),)
    return Statement(t, (goal, *positive), (*exact, *within))
