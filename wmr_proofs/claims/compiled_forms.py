"""Compiled forms of the barriers: the paper's functions, truncation of the series, the smooth one.

For the smooth barrier also: its target, the slope A of V1, and the range of A/w.
"""

from casadi import SX, fmax, gradient

from wmr_ctrl.control.barrier import stable
from wmr_ctrl.control.barrier.proximal import resolvent
from wmr_ctrl.control.barrier.stable import Barrier, smooth_barrier
from wmr_proofs import regions
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Ring
from wmr_proofs.paper_functions import smooth_f, smooth_lyapunov
from wmr_proofs.regions import POSITIVE, Case, Values
from wmr_proofs.statement import Statement, equal, symbols

from .common import CLOSED_FORM, BarrierAxis, barrier_axis


def _within(sign: int) -> Case:
    """0 < |y| < 0.05: y = n/(20 n + m)."""

    def values(n: Values) -> Values:
        return {"y": sign * n["n"] / (20 * n["n"] + n["m"])}

    label = "0 < y < 0.05" if sign > 0 else "-0.05 < y < 0"
    return Case(label, {"n": POSITIVE, "m": POSITIVE}, values)


BEYOND = (
    Case("0.05 < y < 1", {"n": POSITIVE}, lambda n: {"y": (n["n"] + 1) / (n["n"] + 20)}),
    Case("y < -0.05", {"n": POSITIVE}, lambda n: {"y": -n["n"] - 1}),
    Case("-1 < y < -0.05", {"n": POSITIVE}, lambda n: {"y": -(n["n"] + 1) / (n["n"] + 20)}),
)
EVERYWHERE = Ring(regions.all_cases(), CLOSED_FORM)
claim = Claims(by=EVERYWHERE)


@claim("forms.v_c1", (18,), by=Ring(regions.target_cases()))
def target(mutation: Mutation) -> Statement:
    """the compiled v_c1 equals (18).

    The generated code has the paper's target.

    Given: {ALL_LIMITS}; |v_c0| < 1e100.
    """
    a, _, c, u1, u2 = barrier_axis()
    return a.states(stable.stable_minimiser(c, u1, u2) == mutation * a.x)


@claim("forms.w", (18,), by=Ring(regions.all_cases()))
def distance(mutation: Mutation) -> Statement:
    """the compiled v - v_c1 is the difference of v and (18).

    The distance to the target is right even if it is computed in another way.

    Given: {ALL_LIMITS}; |v_c0| < 1e100.
    """
    a = BarrierAxis()
    return a.states(a.stable.w == a.all[0] - mutation * a.x, a.stable.v_c1 == a.x)


@claim("forms.V1", (12, 20))
def value(mutation: Mutation) -> Statement:
    """the compiled V1i, a sum of non-negative terms, equals (20).

    No cancellation of large numbers, and still the same function.

    Given: {ALL_LIMITS}{NO_SERIES}.
    """
    a = BarrierAxis()
    return a.states(equal(a.stable.V1, mutation * a.V))


@claim("forms.quotient", (9, 20))
def quotient(mutation: Mutation) -> Statement:
    """the compiled V1i/A_i times A_i equals V1i.

    The feedback term is the paper's, without a division by A = 0.

    Given: {ALL_LIMITS}{NO_SERIES}.
    """
    a = BarrierAxis()
    return a.states(a.stable.V1_over_A * a.A == mutation * a.V)


@claim("forms.q", (9, 10))
def q(mutation: Mutation) -> Statement:
    """the compiled q times A_i equals v - v_c1.

    The feed-forward factor is the paper's, with its limit at A = 0.

    Given: {ALL_LIMITS}{FINITE}.
    """
    a = BarrierAxis()
    return a.states(a.stable.q * a.A == mutation * a.w)


@claim("forms.closed", (15,), by=Ring(BEYOND, CLOSED_FORM))
def closed_slope(mutation: Mutation) -> Statement:
    """for |y| >= 0.05 the derivative of the compiled y chi(y) is that of phi(y) = -ln(1 - y) - y.

    The closed form is the logarithm of the paper.

    Given: 0.05 <= |y|, y < 1.
    """
    t = symbols("y")
    y = t.y
    return Statement(t, gradient(y * stable._chi(y, 1 - y), y) == 1 / (1 - y) - mutation)


@claim("forms.series", (15,), by=Ring((_within(1), _within(-1))), premises="lemma.integration")
def series_slope(mutation: Mutation) -> Statement:
    """for |y| < 0.05 the compiled series has a derivative within 2^-51 |y| of phi'(y); integrated
    from 0, it is within 2^-52 y^2 of phi(y), about one part in 2^51.

    If the logarithm would lose digits a series replaces it; in double precision both give the same.

    Given: 0 < |y| < 0.05, coefficients as the doubles that they are.
    """
    t = symbols("y")
    y = t.y
    slope = (1 / (1 - y) - 1) - gradient(y * stable._chi(y, 1 - y), y)
    bound = mutation(2.0**-51, 2.0**-56) * abs(y)
    return Statement(t, (bound >= slope, bound >= -slope))


def _compiled(a: BarrierAxis) -> Barrier:
    v, c, u1, u2 = a.all
    return smooth_barrier(c, v, u1, u2)


EVERY = regions.smooth_cases()
CORNERS = "v_c0 zero, v zero", "corner", "kink"
OFF_CORNERS = tuple(case for case in EVERY if not any(at in case.label for at in CORNERS))
ANYWHERE = (*regions.SIDES, *regions.SIDE_EDGES)
TANGENTS = tuple(regions.tangent_case(y, v) for y in ANYWHERE for v in regions.SIDES)
"""v off the corner, where the slope is 0 from both sides."""
COVERED = "cover.smooth-targets cover.beyond"
smooth_claim = Claims(by=Ring(EVERY, CLOSED_FORM), given="{ALL_LIMITS}{FINITE}", premises=COVERED)


@smooth_claim("smooth.V1")
def smooth_value(mutation: Mutation) -> Statement:
    """smooth barrier: the compiled V1i equals (20) with f(v) = -ln((v_u1 - |v|)/(v_u1 - v_u2)) -
    (|v| - v_u2)/(v_u1 - v_u2) beyond v_u2, else 0.

    The sum of non-negative terms is the same function.

    Given: {ALL_LIMITS}{NO_SERIES}.
    """
    a = BarrierAxis()
    return a.states(equal(_compiled(a).V1, mutation * smooth_lyapunov(*a.all)))


@smooth_claim("smooth.convex", by=Ring(TANGENTS, log_lemma=True), premises="lemma.log")
def above_tangent(mutation: Mutation) -> Statement:
    """smooth barrier: f(y) >= f(v) + f'(v) (y - v).

    The smooth barrier function lies above each of its tangents.

    Given: every 0 < v_u2 < v_u1, |v| and |y| < v_u1; |v| = v_u2 left out.
    """
    t = symbols("y v u1 u2", "u1 u2")
    y, v, u1, u2 = t.values()
    line = smooth_f(v, u1, u2) + gradient(smooth_f(v, u1, u2), v) * (y - v)
    return Statement(t, smooth_f(y, u1, u2) >= line + mutation(0, (y - v) ** 2))


@smooth_claim("smooth.v_c1", by=Ring(EVERY), premises=f"prox.optimal {COVERED}")
def smooth_target(mutation: Mutation) -> Statement:
    """smooth barrier: the compiled v_c1 is X_1(v_c0), and w = v - v_c1.

    The generated code aims at the nearest velocity inside the limit.
    """
    a, v, c, u1, u2 = barrier_axis()
    found, nearest = _compiled(a), resolvent(c, SX(1), u1, u2, smooth=True)
    return a.states(found.v_c1 == mutation * nearest, found.w == v - nearest)


@smooth_claim("smooth.slope", by=Ring(OFF_CORNERS, CLOSED_FORM))
def slope(mutation: Mutation) -> Statement:
    """smooth barrier: (v - v_c1)/q is dV1i/dv, the slope A of the compiled V1i.

    The laws' divisor is the slope of the barrier function.

    Given: every 0 < v_u2 < v_u1, |v| < v_u1, any v_c0; off |v| = v_u2 and |v_c0| = v_u2, and v =
    v_c0 = 0 left out{NO_SERIES}.
    """
    a = BarrierAxis()
    found = _compiled(a)
    return a.states(found.q * gradient(found.V1, a.all[0]) == mutation * found.w)


@smooth_claim("smooth.quotient")
def smooth_quotient(mutation: Mutation) -> Statement:
    """smooth barrier: the compiled V1i/A times A = (v - v_c1)/q equals V1i.

    The feedback term is the quotient of the two.

    Given: {ALL_LIMITS}{NO_SERIES}.
    """
    a = BarrierAxis()
    found = _compiled(a)
    return a.states(found.V1_over_A * found.w == mutation * found.q * found.V1)


@smooth_claim("prox.smooth-ratio", by=Ring(EVERY), premises=f"smooth.slope {COVERED}")
def ratio(mutation: Mutation) -> Statement:
    """smooth barrier: 1 <= A/(v - v_c1) <= 1 + 1/(v_u1 - max(|v|, |v_c1|))^2, as compiled (1/q).

    The network's regressor is bounded where V1 is.
    """
    a, v, _, u1, _ = barrier_axis()
    found = _compiled(a)
    top = (1 + mutation(1, 0.9) / (u1 - fmax(abs(v), abs(found.v_c1))) ** 2) * found.q
    return a.states(found.q <= 1, top >= 1)
