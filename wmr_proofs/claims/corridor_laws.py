"""Assumptions of the certified corridor about laws, guard and wheels off their limits.

Under the conditions that are checked for a scenario, the graph is what `wmr_ctrl.theory.corridor`
reads.
"""

import casadi as ca

from wmr_ctrl.control.barrier.stable import smooth_barrier, stable_barrier
from wmr_ctrl.control.guard.guard import MAPS, Bounds, guarded
from wmr_ctrl.control.laws.prox import carried_plainly, mixture
from wmr_ctrl.control.laws.velocity_loop import cut
from wmr_ctrl.world.model.dynamics import force_to_wheel, full_thrust
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import Statement, every, nonnegative, positive, symbols

from .common import EITHER_BARRIER
from .guard_axis import NUMBERS
from .prox import Step

claim = Claims(by=Z3())


@claim(
    "corridor.prox",
    premises="transport.plain prox.linear",
    each=EITHER_BARRIER,
)
def prox(mutation: Mutation, smooth: bool) -> Statement:
    """|E v* + (1-E) c+| <= v_u2 implies that this is the law's v+, as its corridor assumes;
    with either barrier.

    Away from the limits the step is a mixture of where the velocity is carried and the target.

    Given: 0 < v_u2 < v_u1, v_u2 < 1e100, 0 < E < 1; v* = v + c_m - c.
    """
    s = Step(smooth)
    t, carried = s.inputs, s.free.carried
    plainly = carried_plainly(t.v, t.c, t.followed)
    after = mixture(plainly, t.target, s.shares)
    near = [t.u2 >= way * after for way in (1, -1)]
    given = carried == plainly, t.u2 < 1e100, near
    return s.states((s.end == mutation(after, after + carried),), given, ("carried",))


@claim("corridor.mb", each=EITHER_BARRIER)
def mb(mutation: Mutation, smooth: bool) -> Statement:
    """|v|, |v_c0| <= v_u2 imply that V1/A = (v - v_c0)/2 and q = 1; with either barrier.

    Away from the limits the barrier adds nothing to the model-based law.

    Given: 0 < v_u2 < v_u1, v_u2 < 1e100.
    """
    t = symbols("v c u1 u2", "u1 u2")
    v, c, u1, u2 = t.values()
    barrier = (smooth_barrier if smooth else stable_barrier)(c, v, u1, u2)
    near = [mutation(1, 2) * u2 >= abs(item) for item in (v, c)]
    given = u2 > 0, u1 > u2, u2 < 1e100, near
    goals = 2 * barrier.V1_over_A == v - c, barrier.q == 1
    return Statement(t, goals, given)


@claim("corridor.kanayama")
def kanayama(mutation: Mutation) -> Statement:
    """|value| <= limit on both axes implies that the clip leaves the value as it is.

    Within its limits the command is not clipped.

    Given: every limit >= 0.
    """
    t = symbols("a b A B", "A B")
    values, most = ca.vertcat(t.a, t.b), ca.vertcat(t.A, t.B)
    left = cut(values, most)
    inside = [mutation(1, 2) * most[i] >= abs(values[i]) for i in (0, 1)]
    return Statement(t, every(left, values), (nonnegative(t.A, t.B), inside))


@claim(
    "corridor.guard",
)
def guard(mutation: Mutation) -> Statement:
    """With S = M_min alpha: |F + S y|, |S y| <= S (u1 - nbar) - net, |F| <= S (u1 - f_speed) - net
    imply that the guard leaves F as it is, and that its safe point is 0.

    On these conditions the law drives as if there were no guard.

    Given: no late command; M_min, M_max, T, alpha, u1 > 0, nbar, f_speed, brake >= 0, dbar >=
    f_min.
    """
    t = symbols(f"{NUMBERS} y force", NUMBERS)
    bounds = Bounds(**{name: t[name] for name in NUMBERS.split()})
    slope, net = t.M_min * t.alpha, bounds.net
    near, far = (slope * (t.u1 - t[name]) - net for name in ("nbar", "f_speed"))
    sizes = (t.force + slope * t.y, near), (slope * t.y, near), (t.force, far)
    held = guarded(ca.vertcat(t.force, 0), ca.vertcat(t.y, 0), bounds)
    free = [most >= mutation(1, 0.5) * abs(size) for size, most in sizes]
    signs = positive(t.M_min, t.M_max, t.alpha, t.period, t.u1), nonnegative(t.nbar, t.f_speed)
    given = signs, nonnegative(t.brake, net), free
    return Statement(t, (held.force[0] == t.force, held.safe[0] == 0), given)


@claim(
    "corridor.wheels",
    each={"linear-first": {"key": "linear-first"}, "rotation-first": {"key": "rotation-first"}},
)
def wheels(mutation: Mutation, key: str) -> Statement:
    """Torques within tau_max on both wheels imply that either map leaves the force as it is.

    On this condition the wheels' limit does not act.

    Given: r, l, tau_max > 0; the guard's safe point is 0, as it is without a guard.
    """
    t = symbols("force moment r half tau", "r half tau")
    force = ca.vertcat(t.force, t.moment)
    torque = force_to_wheel(t.r, t.half, force)
    phi = full_thrust(t.r, t.tau)
    mapped = MAPS[key](force, phi, t.half, ca.SX.zeros(2))
    weak = [mutation(1, 2) * t.tau >= abs(torque[i]) for i in (0, 1)]
    return Statement(t, every(mapped, force), (positive(t.r, t.half, t.tau), weak))


@claim("corridor.product")
def product(mutation: Mutation) -> Statement:
    """|a + ratio b| <= P and |a - ratio b| <= Q imply 4 ratio |a b| <= max(P^2, Q^2).

    The largest product of two errors follows from how large sums of them get.

    Given: ratio > 0.
    """
    t = symbols("a b P Q ratio", "P Q ratio")
    a, b, P, Q, ratio = t.values()
    sums = (a + ratio * b, a - ratio * b)
    given = ratio > 0, abs(sums[0]) <= P, abs(sums[1]) <= Q
    largest = ca.fmax(P * P, Q * Q)
    size = mutation(4, 5) * ratio * abs(a * b)
    return Statement(t, largest >= size, given)
