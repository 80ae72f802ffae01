"""Why the barrier function works: proximal map, Moreau envelope, Bregman distance (P1-P8)."""

from casadi import gradient, if_else, substitute

from wmr_proofs import paper_barrier as barrier
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3, Ring
from wmr_proofs.regions import all_cases, target_cases
from wmr_proofs.statement import Statement, between, positive, symbols

from .common import (
    CLOSED_FORM,
    BarrierAxis,
    LawGraph,
    barrier_axis,
)

NO_CORNER = tuple(c for c in all_cases() if "middle" not in c.label and "edge" not in c.label)
claim = Claims(by=Ring(all_cases(), log_lemma=True))


@claim("P1", (12, 81), premises="lemma.log")
def bregman(mutation: Mutation) -> Statement:
    """V1i = w^2/2 + D_f(v, v_c1), the Bregman distance of f, which is >= 0; w = v - v_c1.

    The barrier function is a squared distance plus something that only grows towards the limit.

    Given: {ALL_LIMITS}.
    """
    a, v, c, u1, u2 = barrier_axis()
    distance = barrier.f(v, u1, u2) - barrier.f(a.x, u1, u2) - mutation * (c - a.x) * a.w
    return a.states(a.V - 0.5 * a.w**2 == distance, distance >= 0)


@claim("P1.prox", (16, 18), premises="lemma.log")
def subgradient(mutation: Mutation) -> Statement:
    """v_c0 - v_c1 is a subgradient of f at v_c1: v_c1 is the proximal map of f, and -g its Moreau
    envelope.

    The target velocity is a smooth clip of v_c0 to the limit, of the kind known from optimisation.

    Given: {ALL_LIMITS}.
    """
    # f(y) >= f(v_c1) + (v_c0 - v_c1)(y - v_c1) for every y (here v): v_c1 = prox_f(v_c0).
    a, v, c, u1, u2 = barrier_axis()
    line = barrier.f(a.x, u1, u2) + mutation * (c - a.x) * (v - a.x)
    return a.states(barrier.f(v, u1, u2) >= line)


@claim("P2", (16, 25), by=Ring(target_cases(edges=False)))
def envelope_slope(mutation: Mutation) -> Statement:
    """dg/dv_c0 = v_c1 - v_c0.

    The corrected sign of (25), as a derivative by v_c0 and not by time.

    Given: {OFF_EDGES}.
    """
    a, _, c, u1, u2 = barrier_axis()
    return a.states(gradient(barrier.g(c, u1, u2), c) == a.x - mutation * c)


@claim("P3", (10, 12), premises="lemma.log")
def three_points(mutation: Mutation) -> Statement:
    """A w >= V1i + w^2/2.

    The slope of the barrier function is never small where its value is large.

    Given: {ALL_LIMITS}.
    """
    a = BarrierAxis()
    return a.states(a.A * a.w >= a.V + mutation(0.5, 0.75) * a.w**2)


@claim("P4", (9, 10), by=Ring(all_cases()))
def q_range(mutation: Mutation) -> Statement:
    """0 <= q <= 1 for the compiled q = (v - v_c1)/A.

    The feed-forward is never amplified.

    Given: {ALL_LIMITS}{FINITE}.
    """
    a = BarrierAxis()
    return a.states(a.stable.q >= 0, mutation(1, 0.5) >= a.stable.q)


@claim(
    "P4.positive",
    (9, 10),
    by=Ring(NO_CORNER),
)
def q_positive(mutation: Mutation) -> Statement:
    """q > 0 outside the middle region (0 there only in the limit v -> v_c1).

    The feed-forward never has the wrong sign.

    Given: |v_c0| <= v_u2 or |v_c0| > v_u2 + 1/(v_u1 - v_u2){FINITE}.
    """
    a = BarrierAxis()
    return a.states(mutation * a.stable.q > 0)


@claim(
    "P5",
    (9, 12),
    by=Ring(all_cases(), CLOSED_FORM, log_lemma=True),
    premises="lemma.log",
)
def quotient_range(mutation: Mutation) -> Statement:
    """V1i/A_i as compiled lies between 0 and v - v_c1.

    The feedback never exceeds the distance to the target, so it stays bounded near the limit.

    Given: {ALL_LIMITS}{NO_SERIES}.
    """
    a = BarrierAxis()
    product = a.stable.V1_over_A * a.stable.w
    return a.states(product >= 0, mutation(1, 0.5) * a.stable.w**2 >= product)


@claim("P6", (18,), by=Ring(target_cases(edges=False)))
def target_slope(mutation: Mutation) -> Statement:
    """dv_c1/dv_c0 = 1, 0 or 1/(1 + 1/(v_u1 - |v_c1|)^2): between 0 and 1.

    The target velocity never moves faster than v_c0.

    Given: {OFF_EDGES}.
    """
    a, _, c, u1, u2 = barrier_axis()
    slope = gradient(a.x, c)
    edge = u2 + 1 / (u1 - u2)
    far = 1 / (1 + mutation / (u1 - abs(a.x)) ** 2)
    written = if_else(abs(c) <= u2, 1, if_else(abs(c) <= edge, 0, far))
    return a.states(slope == written, slope >= 0, slope <= 1)


@claim("P7", (9, 18), by=Ring(target_cases(edges=False)))
def q_at_target(mutation: Mutation) -> Statement:
    """at v = v_c1 the compiled q equals dv_c1/dv_c0.

    On target, the law tells the robot to follow the target's own acceleration.

    Given: {OFF_EDGES}{FINITE}.
    """
    a, v, c, _, _ = barrier_axis()
    return a.states(substitute(a.stable.q, v, a.x) == gradient(a.x, c) + mutation(0, c))


@claim("P8", (9,), by=Z3(), premises="P4 P5")
def bounded_command(mutation: Mutation) -> Statement:
    """|commanded acceleration| <= rho |v - v_c1| + |v_c0'| on the law's graph.

    The command stays bounded right up to the speed limit; this barrier does not push infinitely
    hard.

    Given: P4 and P5 for the inner values.
    """
    law = LawGraph("mb")
    names = {n: law[n] for n in ("gains.mb.rho[1]", "model.m", "model.I")}
    t = names | symbols("quotient q w cdot friction")
    rho, mass = names["gains.mb.rho[1]"], names["model.m"]
    force = law.force[0] - t.friction
    P5 = between(0, t.quotient * t.w, t.w**2), t.w**2 >= t.quotient**2
    given = positive(rho, mass), between(0, t.q, 1), P5
    bound = mutation * rho * abs(t.w) + abs(t.cdot)
    inner = law.parts(0, "quotient q cdot friction")
    return Statement(t, bound * mass >= abs(force), given, inner)
