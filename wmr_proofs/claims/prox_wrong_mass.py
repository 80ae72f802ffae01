"""The sampled-data law with a wrong mass and a constant target: the limit of the loop."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import casadi as ca

from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Z3, Both, Ring
from wmr_proofs.regions import FREE, POSITIVE, Case
from wmr_proofs.statement import Statement, positive, symbols

from .common import BOTH_AXES, VELOCITY_NAMES, named_axes
from .prox_push import Sampled


def _matrix(mu: ca.SX, a: ca.SX, share: ca.SX) -> ca.SX:
    """The loop of (w, T f/M^)."""
    return ca.vertcat(ca.horzcat(1 - mu * a, mu), ca.horzcat(-share * a * (1 - mu), 1 - share * mu))


FAST = {"L": "0.3", "least": "1/4", "p": "1/6", "s": "53/5", "g": "0.93"}
GENTLE = {"L": "0.07", "least": "1/10", "p": "1/5", "s": "60", "g": "0.993"}

LOOP = "prox.loop-force prox.loop-observer prox.loop-observer-angular"
BELIEFS = rows(key=("", "-gentle"), numbers=(FAST, GENTLE))
claim = Claims(by=Z3())


@claim(
    "prox.loop-force",
    each=BOTH_AXES,
)
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


def sampled_before(axis: int) -> Both:
    """Z3 and exact algebra: one torque and the old velocity follow from the hypotheses."""
    of, inertia, v = f"[{axis + 1}]", ("model.m", "model.I")[axis], VELOCITY_NAMES[axis]
    names = (f"f_hat{of}", "tau_applied[2]", v, "a", "w", "mu", *["drag"] * (axis == 0))
    sure = ("clock.control", inertia, "robot.r", "robot.l")

    def values(n: Mapping[str, Any]) -> dict[str, Any]:
        """Values that solve both hypotheses."""
        asked = n[f"f_hat{of}"] - n[inertia] * n["a"] * n["w"] / n["clock.control"]
        left, pushed = n["tau_applied[2]"], n["robot.r"] * asked
        dragged, turned = n["robot.r"] * n.get("drag", 0), pushed / n["robot.l"]
        right = dragged + pushed - left if axis == 0 else left + turned
        old = n[v] - n["mu"] * n["clock.control"] * asked / n[inertia]
        kept = {name: n[name] for name in (*names, *sure)}
        fall = -n["rate"] / (1 + n["rate"])
        return kept | {"tau_applied[1]": right, f"v_previous{of}": old, "fall": fall}

    numbers = dict.fromkeys(names, FREE) | dict.fromkeys((*sure, "rate"), POSITIVE)
    case = Case("after the first sample", numbers, values, {"started": POSITIVE})
    return Both(Z3(), Ring((case,)))


@claim(
    "prox.loop-observer{of}",
    by=sampled_before,
    over=named_axes(),
)
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


@claim(
    "prox.jury",
    premises=LOOP,
)
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


@claim("prox.light-model", premises="prox.jury")
def light_model(mutation: Mutation) -> Statement:
    """M^ <= (4/3) M makes the velocity loop stable for every rho, T and wo.

    If in doubt, state a mass that is too small rather than too large. This is about a target that
    is held: the tracking loop makes a larger (a = (1 - E)(1 + T k1) on the linear axis), and
    `check` has its limits.

    Given: 0 < a, L < 1.
    """
    t = symbols("mu a L")
    mu, a, L = t.values()
    given = [part for name in ("a", "L") for part in (t[name] > 0, t[name] < 1)]
    share = mutation(4 / ca.SX(3), ca.SX(1.5))
    edge = 4 - mu * (2 * (a + L) - a * L)
    det = 1 - mu * (a + L) + mu * a * L
    light = mu > 0, share >= mu
    return Statement(t, (edge > 0, det < 1), (given, light))


@claim(
    "prox.any-mass.step{key}",
    given="{MASSES}; no disturbance",
    premises=LOOP,
    wording="w^2 + 2 p w q + s q^2 falls by g^2 in a sample for every mu in [5/8, 5/3] and every a "
    "in [{numbers[least]}, 1], and is at least (w^2 + q^2)/2; L, p, s and g as in "
    "prox.wrong-mass{key}",
    over=tuple(table | {"corners": False} for table in BELIEFS),
)
@claim(
    "prox.wrong-mass{key}",
    given="{MASSES}: at its corners; no disturbance",
    premises=LOOP,
    over=BELIEFS,
)
def wrong_mass(mutation: Mutation, numbers: Mapping[str, str], corners: bool = True) -> Statement:
    """w^2 + 2 p w q + s q^2 falls by g^2 in a sample at the four corners mu = 5/8 or 5/3, a =
    {numbers[least]} or 1: L = {numbers[L]}, p = {numbers[p]}, s = {numbers[s]}, g = {numbers[g]}.

    With a believed mass that is wrong by that much, nothing grows.
    """
    t = symbols("w q mu a " + " ".join(numbers))
    p, s = t.p, t.s
    w, q = ca.vertsplit(_matrix(t.mu, t.a, t.L) @ ca.vertcat(t.w, t.q))
    form = t.w**2 + 2 * p * t.w * t.q + s * t.q**2
    left = t.g**2 * form
    shares = {name: Fraction(value) for name, value in numbers.items()}
    exact = [x.denominator * t[name] == x.numerator for name, x in shares.items()]
    sides = (8 * t.mu - 5) * (3 * t.mu - 5), (t.a - t.least) * (t.a - 1)
    within = [side == 0 if corners else -side >= 0 for side in sides]
    goal = mutation(1, 0.9) * left >= w**2 + 2 * p * w * q + s * q**2
    positive = () if corners else (form >= 0.5 * (t.w**2 + t.q**2),)
    return Statement(t, (goal, positive), (exact, within))
