"""The barrier function and its minimiser: Eqs. (10)-(20), (74)-(81).

Then why it works: proximal map, Moreau envelope, Bregman distance (P1-P8).
"""

from casadi import gradient, hessian, if_else, substitute, vertcat

from wmr_proofs import paper_barrier as barrier
from wmr_proofs.claim import CORRECTED, OURS, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Z3, Refute, Ring
from wmr_proofs.paper_functions import total_barrier
from wmr_proofs.regions import all_cases, at, open_cases, paired_cases, target_cases
from wmr_proofs.statement import Statement, above, between, equal, positive, symbols

from .common import CLOSED_FORM, BarrierAxis, LawGraph, barrier_axis

PAIRS = paired_cases()
SMOOTH = tuple(c for c in target_cases(edges=False) if "middle" not in c.label)
FAR = tuple(c for c in target_cases(edges=False) if "far" in c.label)
NEAR = tuple(c for c in all_cases() if c.label.startswith(("v_c0 near", "v_c0 zero")))
claim = Claims(by=Ring(open_cases()), form=PRINTED, given="{ALL_LIMITS}")


@claim("eq12", (12, 13, 14, 15, 16), by=Ring(all_cases()))
def parts(mutation: Mutation) -> Statement:
    """V1i = z^2/2 + f(v) + g(v_c0) with z = v - v_c0.

    The function that the laws decrease is the paper's.
    """
    a, v, c, u1, u2 = barrier_axis()
    z = v - c
    written = 0.5 * z * z + barrier.f(v, u1, u2) + mutation * barrier.g(c, u1, u2)
    return a.states(equal(a.V, written))


@claim("eq19", (19,), by=Ring(PAIRS, spare=12))
def two_axes(mutation: Mutation) -> Statement:
    """V1 = V11 + V12.

    Each axis can be treated separately.

    Given: {OFF_EDGES}.
    """
    one, two = BarrierAxis("1"), BarrierAxis("2")
    columns = [vertcat(x, y) for x, y in zip(one.all, two.all, strict=True)]
    return one.states(total_barrier(*columns) == one.V + mutation * two.V, more=two)


@claim("eq20", (20,), by=Ring(all_cases()))
def spelt_out(mutation: Mutation) -> Statement:
    """V1i = (v - v_c0)^2/2 + f(v) - (v_c1 - v_c0)^2/2 - f(v_c1).

    The barrier function measures how much worse the present velocity is than the best allowed one.
    """
    a = BarrierAxis()
    return a.states(equal(a.V, a.cost(a.all[0]) - mutation * a.cost(a.x)))


@claim("eq17-18", (17, 18), by=Ring(all_cases(), log_lemma=True), premises="lemma.log")
def minimum(mutation: Mutation) -> Statement:
    """v_c1 of (18) is the one and only minimiser of (v - v_c0)^2/2 + f(v): the cost exceeds its
    value there by at least (v - v_c1)^2/2.

    The target velocity is the best one that the limit allows, and there is no second best.
    """
    a, v, _, _, _ = barrier_axis()
    return a.states(a.cost(v) - a.cost(a.x) >= mutation(mutation * 0.5 * a.w**2, 0.6 * a.w**2))


@claim("eq17-18.slope", (10, 18), form=OURS, by=Z3())
def slope_sign(mutation: Mutation) -> Statement:
    """(A - (v - v_c1)) (v - v_c1) >= 0: the cost falls towards v_c1 from either side, at least as
    fast as the distance.

    There is no valley in which the velocity could get stuck.
    """
    a = BarrierAxis()
    return a.states((a.A - mutation(1, 1.25) * a.w) * a.w >= 0, given=a.inside)


@claim("eq18.inside", (18,), form=OURS, by=Z3())
def inside(mutation: Mutation) -> Statement:
    """|v_c1| < v_u1 for every v_c0.

    However far away the robot is, it never aims beyond its speed limit.
    """
    a, _, _, u1, u2 = barrier_axis()
    limit = mutation(u1, u2)
    return a.states(limit > a.x, a.x > -limit, given=a.inside)


@claim("eq18.stationary", (18,), by=Ring(FAR))
def stationary(mutation: Mutation) -> Statement:
    """beyond v_u2 + 1/(v_u1 - v_u2) the root of (18) solves |v_c1| + 1/(v_u1 - |v_c1|) = |v_c0|.

    The formula with the root is right.

    Given: every 0 < v_u2 < v_u1, |v_c0| beyond v_u2 + 1/(v_u1 - v_u2).
    """
    a, _, c, u1, _ = barrier_axis()
    size = abs(a.x)
    return a.states(size + mutation / (u1 - size) == abs(c))


@claim("eq74", (10, 74))
def slope(mutation: Mutation) -> Statement:
    """dV1i/dv = A_i.

    A is the slope of the barrier function.

    Given: {OFF_EDGES}.
    """
    a = BarrierAxis()
    return a.states(gradient(a.V, a.all[0]) == mutation * a.A)


@claim("eq75", (11, 75))
def curvature(mutation: Mutation) -> Statement:
    """d2V1i/dv2 = 1 + h/(v_u1 - |v|)^2 >= 1 (the printed indices mix the axes).

    The barrier function is at least as curved as a plain square.

    Given: {OFF_EDGES}.
    """
    a, v, _, u1, u2 = barrier_axis()
    second = hessian(a.V, v)[0]
    bend = if_else(barrier.h(v, u2), mutation / (u1 - abs(v)) ** 2, 0)
    return a.states(second == 1 + bend, second >= 1)


@claim("eq76-77", (76, 77))
def half_square(mutation: Mutation) -> Statement:
    """d/dv (v - v_c1)^2/2 = v - v_c1, and its second derivative is 1.

    Reference curve for the comparison with the barrier.
    """
    a, v, _, _, _ = barrier_axis()
    square = 0.5 * a.w**2
    return a.states(gradient(square, v) == mutation * a.w, equal(hessian(square, v)[0], 1))


@claim("eq78", (78,), by=Ring(target_cases()))
def zero_at_target(mutation: Mutation) -> Statement:
    """V1i = 0 at v = v_c1.

    The target velocity has the value 0.
    """
    a, _, c, u1, u2 = barrier_axis()
    return a.states(barrier.lyapunov(mutation * a.x, c, u1, u2) == 0)


@claim("eq79.printed", (79,), by=Refute((at(c=3, u1=1, u2="4/5"),)))
def flat_at_target(mutation: Mutation) -> Statement:
    """dV1i/dv = 0 at v = v_c1.

    False in the middle region: there the barrier function has a corner at the target, like |v -
    v_u2|.

    Given: every v_c0.
    """
    a, _, c, u1, u2 = barrier_axis()
    return a.states(barrier.a_term(a.x, mutation * c, u1, u2) == 0)


@claim("eq79", (79,), form=CORRECTED, by=Ring(SMOOTH))
def eq79(mutation: Mutation) -> Statement:
    """dV1i/dv = 0 at v = v_c1 for |v_c0| < v_u2 and beyond v_u2 + 1/(v_u1 - v_u2).

    Outside the middle region the barrier function is smooth at the target.

    Given: |v_c0| < v_u2 or |v_c0| > v_u2 + 1/(v_u1 - v_u2).
    """
    return flat_at_target(mutation)


@claim("eq80", (80,))
def curvatures_compared(mutation: Mutation) -> Statement:
    """d2V1i/dv2 >= d2/dv2 (v - v_c1)^2/2 > 0.

    The barrier function is convex.

    Given: {OFF_EDGES}.
    """
    a, v, _, _, _ = barrier_axis()
    plain = hessian(0.5 * a.w**2, v)[0]
    return a.states(hessian(a.V, v)[0] >= mutation(1, 1.5) * plain, above(plain))


@claim("eq81", (81,), by=Ring(all_cases(), log_lemma=True), premises="lemma.log")
def lower_bound(mutation: Mutation) -> Statement:
    """V1i >= (v - v_c1)^2/2, in spite of (79), which the paper's own argument relies on.

    If the barrier function is small, the velocity is near its target.
    """
    a = BarrierAxis()
    return a.states(mutation(0.5, 0.6) * a.w**2 <= a.V)


@claim("thm1.velocity", (30,), by=Ring(NEAR, log_lemma=True), premises="eq30 eq81")
def near_target(mutation: Mutation) -> Statement:
    """(Theorem 1) z -> 0 where |v_c0i| < v_u2i: z^2 <= 2 V1i, and V1i falls by exp(-rho t) (eq30).

    True under the same hypotheses.

    Given: {ALL_LIMITS}; |v_c0| < v_u2.
    """
    a, v, c, _, _ = barrier_axis()
    return a.states(mutation(1, 1.2) * (v - c) ** 2 <= 2 * a.V)


NO_CORNER = tuple(c for c in all_cases() if "middle" not in c.label and "edge" not in c.label)
why_claim = Claims(by=Ring(all_cases(), log_lemma=True))


@why_claim("P1", (12, 81), premises="lemma.log")
def bregman(mutation: Mutation) -> Statement:
    """V1i = w^2/2 + D_f(v, v_c1), the Bregman distance of f, which is >= 0; w = v - v_c1.

    The barrier function is a squared distance plus something that only grows towards the limit.

    Given: {ALL_LIMITS}.
    """
    a, v, c, u1, u2 = barrier_axis()
    distance = barrier.f(v, u1, u2) - barrier.f(a.x, u1, u2) - mutation * (c - a.x) * a.w
    return a.states(a.V - 0.5 * a.w**2 == distance, distance >= 0)


@why_claim("P1.prox", (16, 18), premises="lemma.log")
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


@why_claim("P2", (16, 25), by=Ring(target_cases(edges=False)))
def envelope_slope(mutation: Mutation) -> Statement:
    """dg/dv_c0 = v_c1 - v_c0.

    The corrected sign of (25), as a derivative by v_c0 and not by time.

    Given: {OFF_EDGES}.
    """
    a, _, c, u1, u2 = barrier_axis()
    return a.states(gradient(barrier.g(c, u1, u2), c) == a.x - mutation * c)


@why_claim("P3", (10, 12), premises="lemma.log")
def three_points(mutation: Mutation) -> Statement:
    """A w >= V1i + w^2/2.

    Where the barrier function is large, its slope is large.

    Given: {ALL_LIMITS}.
    """
    a = BarrierAxis()
    return a.states(a.A * a.w >= a.V + mutation(0.5, 0.75) * a.w**2)


@why_claim("P4", (9, 10), by=Ring(all_cases()))
def q_range(mutation: Mutation) -> Statement:
    """0 <= q <= 1 for the compiled q = (v - v_c1)/A.

    The feed-forward is never amplified.

    Given: {ALL_LIMITS}{FINITE}.
    """
    a = BarrierAxis()
    return a.states(a.stable.q >= 0, mutation(1, 0.5) >= a.stable.q)


@why_claim("P4.positive", (9, 10), by=Ring(NO_CORNER))
def q_positive(mutation: Mutation) -> Statement:
    """q > 0 outside the middle region (0 there only in the limit v -> v_c1).

    The feed-forward never has the wrong sign.

    Given: |v_c0| <= v_u2 or |v_c0| > v_u2 + 1/(v_u1 - v_u2){FINITE}.
    """
    a = BarrierAxis()
    return a.states(mutation * a.stable.q > 0)


@why_claim("P5", (9, 12), by=Ring(all_cases(), CLOSED_FORM, log_lemma=True), premises="lemma.log")
def quotient_range(mutation: Mutation) -> Statement:
    """V1i/A_i as compiled lies between 0 and v - v_c1.

    The feedback never exceeds the distance to the target, so it stays bounded near the limit.

    Given: {ALL_LIMITS}{NO_SERIES}.
    """
    a = BarrierAxis()
    product = a.stable.V1_over_A * a.stable.w
    return a.states(product >= 0, mutation(1, 0.5) * a.stable.w**2 >= product)


@why_claim("P6", (18,), by=Ring(target_cases(edges=False)))
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


@why_claim("P7", (9, 18), by=Ring(target_cases(edges=False)))
def q_at_target(mutation: Mutation) -> Statement:
    """at v = v_c1 the compiled q equals dv_c1/dv_c0.

    On target, the law tells the robot to follow the target's own acceleration.

    Given: {OFF_EDGES}{FINITE}.
    """
    a, v, c, _, _ = barrier_axis()
    return a.states(substitute(a.stable.q, v, a.x) == gradient(a.x, c) + mutation(0, c))


@why_claim("P8", (9,), by=Z3(), premises="P4 P5")
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
    P5 = between(0, t.quotient * t.w, t.w**2), t.w**2 >= t.quotient**2
    given = positive(rho, mass), between(0, t.q, 1), P5
    bound = mutation * rho * abs(t.w) + abs(t.cdot)
    inner = law.parts(0, "quotient q cdot friction")
    return Statement(t, bound * mass >= abs(law.force[0] - t.friction), given, inner)
