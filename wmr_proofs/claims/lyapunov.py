"""The barrier function in time: Eqs. (9), (21)-(30), on the functions and on the law's graph."""

from casadi import SX, if_else, jtimes, vertcat

from wmr_ctrl.world.model.dynamics import acceleration
from wmr_proofs import paper_barrier as barrier
from wmr_proofs import regions
from wmr_proofs.claim import CORRECTED, OURS, PRINTED, Claims, Mutation
from wmr_proofs.methods.spec import Refute, Ring
from wmr_proofs.paper_functions import target_rate, total_barrier
from wmr_proofs.regions import at
from wmr_proofs.statement import Statement, symbols

from .common import CLOSED_FORM, BarrierAxis, LawGraph, named_axes


class Moving(BarrierAxis):
    """One axis with the ``rates`` of v and v_c0."""

    def __init__(self, suffix: str = "") -> None:
        super().__init__(suffix)
        self.rates = symbols(f"vdot{suffix} cdot{suffix}")
        self.symbols |= self.rates

    def along(self, expr: SX) -> SX:
        """Time derivative of an expression of v and v_c0."""
        v, c, _, _ = self.all
        return jtimes(expr, vertcat(v, c), vertcat(*self.rates.values()))


def x_rate(m: Moving) -> SX:
    """v_c1' of one axis."""
    _, c, u1, u2 = m.all
    return target_rate(c, m.rates.cdot, u1, u2)


def at_target(m: Moving) -> SX:
    """[sgn(v_c1) v_c1'/(v_u1 - |v_c1|) where |v_c1| > v_u2], of Eqs. (23), (24)."""
    _, _, u1, u2 = m.all
    return if_else(barrier.h(m.x, u2), barrier.sign(m.x) * x_rate(m) / (u1 - abs(m.x)), 0)


def two_axes() -> tuple[Moving, Moving, SX]:
    """Both axes, and V1' of them together."""
    m, n = Moving("1"), Moving("2")
    columns = [vertcat(x, y) for x, y in zip(m.all, n.all, strict=True)]
    rates = vertcat(*m.rates.values(), *n.rates.values())
    return m, n, jtimes(total_barrier(*columns), vertcat(*m.all[:2], *n.all[:2]), rates)


OPEN35, PAIRS = Ring(regions.open_cases()), Ring(regions.paired_cases(), spare=12)
TARGETS7 = Ring(regions.target_cases(edges=False))
LAW = tuple(Ring(regions.law_cases(regions.open_cases(), axis), CLOSED_FORM) for axis in (0, 1))
NONZERO = regions.off_target_cases()

claim = Claims(by=OPEN35, form=PRINTED)


@claim("eq21", (21,))
def sum_rule(mutation: Mutation) -> Statement:
    """V1i' = z z' + f' + g', term by term.

    Where the change of the barrier function comes from.

    Given: {OFF_EDGES}.
    """
    m = Moving()
    v, c, u1, u2 = m.all
    v_dot, c_dot = m.rates.values()
    parts = (v - c) * (v_dot - c_dot) + m.along(barrier.f(v, u1, u2))
    parts += mutation * m.along(barrier.g(c, u1, u2))
    return m.states(m.along(m.V) == parts)


@claim("eq22", (22,))
def barrier_rate(mutation: Mutation) -> Statement:
    """f' = sgn(v) v'/(v_u1 - |v|) where |v| > v_u2, else 0.

    The barrier term acts only near the limit.

    Given: {OFF_EDGES}.
    """
    m = Moving()
    v, _, u1, u2 = m.all
    near = mutation * barrier.sign(v) * m.rates.vdot / (u1 - abs(v))
    return m.states(m.along(barrier.f(v, u1, u2)) == if_else(barrier.h(v, u2), near, 0))


@claim("eq23", (23,), by=TARGETS7)
def minimum_rate(mutation: Mutation) -> Statement:
    """g' = -(v_c1 - v_c0)(v_c1' - v_c0') - [sgn(v_c1) v_c1'/(v_u1 - |v_c1|)].

    How the reference value moves with the target.

    Given: {OFF_EDGES}.
    """
    m = Moving()
    _, c, u1, u2 = m.all
    written = -(m.x - c) * (x_rate(m) - m.rates.cdot) - mutation * at_target(m)
    return m.states(m.along(barrier.g(c, u1, u2)) == written)


@claim("eq24", (24,), by=TARGETS7)
def envelope(mutation: Mutation) -> Statement:
    """(v_c1 - v_c0) v_c1' + [sgn(v_c1) v_c1'/(v_u1 - |v_c1|)] = 0.

    At the minimiser, a small change of the velocity costs nothing.

    Given: {OFF_EDGES}.
    """
    m = Moving()
    return m.states((m.x - m.all[1]) * x_rate(m) + mutation * at_target(m) == 0)


@claim("eq25.printed", (25,), by=Refute((at(v=0, c=2, u1=1, u2="4/5", cdot=1),)))
def eq25_printed(mutation: Mutation) -> Statement:
    """g' = -(v_c1 - v_c0) v_c0'.

    The sign is wrong wherever the target velocity is not v_c0 itself, that is whenever the limit
    matters.

    Given: {OFF_EDGES}.
    """
    return g_rate(-mutation)


@claim("eq25", (25,), form=CORRECTED, by=TARGETS7)
def g_rate(mutation: Mutation) -> Statement:
    """g' = +(v_c1 - v_c0) v_c0'.

    With this sign (26) follows, as the paper needs.

    Given: {OFF_EDGES}.
    """
    m = Moving()
    _, c, u1, u2 = m.all
    return m.states(m.along(barrier.g(c, u1, u2)) == mutation * (m.x - c) * m.rates.cdot)


@claim("eq26", (26,), by=PAIRS)
def both_axes(mutation: Mutation) -> Statement:
    """V1' = A' v' - (v - v_c1)' v_c0', both axes together (it follows from the corrected (25), not
    from the printed one).

    The law's effect on the barrier function, and that of the moving target.

    Given: {OFF_EDGES}.
    """
    m, n, rate = two_axes()
    terms = [a.A * a.rates[f"vdot{a.suffix}"] - a.w * a.rates[f"cdot{a.suffix}"] for a in (m, n)]
    return Statement(m | n.symbols, rate == terms[0] + mutation * terms[1])


@claim("eq27", (27,), by=PAIRS)
def split(mutation: Mutation) -> Statement:
    """V1' = V11' + V12'.

    The axes do not interfere.

    Given: {OFF_EDGES}.
    """
    m, n, rate = two_axes()
    return Statement(m | n.symbols, rate == m.along(m.V) + mutation * n.along(n.V))


@claim("eq28", (28,))
def per_axis(mutation: Mutation) -> Statement:
    """V1i' = A_i v_i' - (v_i - v_c1i) v_c0i', all 35 regions of v and v_c0.

    The same for each axis separately.

    Given: {OFF_EDGES}.
    """
    m = Moving()
    v_dot, c_dot = m.rates.values()
    return m.states(m.along(m.V) == m.A * v_dot - mutation * m.w * c_dot)


@claim("eq09{of}", (9,), by=lambda axis: LAW[axis], over=named_axes(".angular"))
def command(mutation: Mutation, axis: int) -> Statement:
    """A (F - F1) = M1 (-rho V1i + (v - v_c1) v_c0') for the model-based law's own graph, {where}
    axis.

    The compiled law is the paper's, only evaluated without dividing by A.

    Given: {NOMINAL}.
    """
    law = LawGraph("mb")
    k, t = axis + 1, law.symbols
    v, u1, u2 = t[("v1", "omega")[axis]], t[f"limits.v_u1[{k}]"], t[f"limits.v_u2[{k}]"]
    free, rho = symbols("c cdot"), t[f"gains.mb.rho[{k}]"]
    c = free.c
    mass, friction = (law.own(item)[axis] for item in (law.context.mass, law.context.friction))
    a, value = barrier.a_term(v, c, u1, u2), barrier.lyapunov(v, c, u1, u2)
    bracket = -rho * value + mutation * (v - barrier.minimiser(c, u1, u2)) * free.cdot
    goal = a * law.force[axis] == mass * bracket + a * friction
    return Statement(t | free, goal, (), law.inner(axis))


@claim("eq29.printed", (29,), by=Ring(NONZERO))
def eq29_printed(mutation: Mutation) -> Statement:
    """V1i' = +rho V1i, as the paper's text reads.

    Read literally the velocity error would grow. The missing minus may be a misprint of the text at
    hand.

    Given: {OFF_EDGES}; A != 0.
    """
    return literal_decay(-mutation)


@claim("eq29", (29,), form=CORRECTED, by=Ring(NONZERO))
def literal_decay(mutation: Mutation) -> Statement:
    """V1i' = -rho V1i under (9), where A is not 0.

    The distance to the target velocity, measured by the barrier function, shrinks at the chosen
    rate.

    Given: {OFF_EDGES}; A != 0.
    """
    m = Moving()
    v, c, _, _ = m.all
    rho, c_dot = SX.sym("rho"), m.rates.cdot
    command = (-rho * m.V + m.w * c_dot) / m.A
    rate = jtimes(m.V, vertcat(v, c), vertcat(command, c_dot))
    return Statement(m | {"rho": rho}, rate == -mutation * rho * m.V)


@claim("eq30.law{of}", (29, 30), form=OURS, by=lambda axis: LAW[axis], over=named_axes())
def decay(mutation: Mutation, axis: int) -> Statement:
    """V1i' = -rho_i V1i for the compiled model-based law, {where} axis, A = 0 included.

    The law that runs on the robot has the property of the theorem, not just the formula on paper.

    Given: {NOMINAL}.
    """
    # Eqs. (29), (30): V1i' + sign rho_i V1i = 0 for the law's own graph in the model's dynamics.
    # V1i is the paper's; the force is the System's, with v_c0 and v_c0' free.
    law = LawGraph("mb")
    k, t = axis + 1, law.symbols
    v = t[("v1", "omega")[axis]]
    rho = t[f"gains.mb.rho[{k}]"]
    free = symbols("c cdot")
    v_dot = acceleration(law.own(law.context.mass), law.force, law.own(law.context.friction))[axis]
    value = barrier.lyapunov(v, free.c, t[f"limits.v_u1[{k}]"], t[f"limits.v_u2[{k}]"])
    rate = jtimes(value, vertcat(v, free.c), vertcat(v_dot, free.cdot))
    return Statement(t | free, rate == -mutation * rho * value, (), law.inner(axis))


@claim(
    "eq30.printed",
    (30,),
    by=Refute((at(v="4/5", c="1/2", u1=1, u2="4/5", cdot=5, rho=15, h="1/1000000"),)),
)
def quotient_at_kink(mutation: Mutation) -> Statement:
    """V1' = -rho V1 at every instant, |v| = v_u2 included.

    Exactly where the barrier begins, the acceleration that the law computes makes the barrier
    function rise for an instant (here at 13 1/s instead of falling). It holds at almost every
    instant, which is enough for the decay.

    Given: |v| = v_u2; change of V1i over at most 1 microsecond compared with -rho V1i, tolerance 1.
    """
    # The change of V1i over a short time h from v = v_u2, with the command at the start held.
    m = Moving()
    v, c, u1, u2 = m.all
    t = m | symbols("rho h")
    command = (-t.rho * m.V + mutation * m.w * t.cdot) / m.A
    change = (barrier.lyapunov(v + t.h * command, c + t.h * t.cdot, u1, u2) - m.V) / t.h
    given = m.inside, v == u2, t.h > 0, 1000000 * t.h <= 1, t.rho > 0
    del t["vdot"]
    return Statement(t, abs(change + t.rho * m.V) <= 1, given)
