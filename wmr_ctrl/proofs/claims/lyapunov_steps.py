"""Statements about the barrier function in time, Eqs. (9), (21)-(30)."""

from __future__ import annotations

from functools import cached_property

import casadi as ca

from wmr_ctrl.barrier import paper as barrier
from wmr_ctrl.barrier.lyapunov import target_rate, total_barrier
from wmr_ctrl.model.dynamics import acceleration
from wmr_ctrl.proofs.claims.common import BarrierAxis, LawGraph
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols


class Moving(BarrierAxis):
    """One axis with the rates of v and v_c0."""

    @cached_property
    def rates(self) -> dict[str, ca.SX]:
        """v' and v_c0', made once."""
        return symbols(f"vdot{self.suffix} cdot{self.suffix}")

    @property
    def names(self) -> dict[str, ca.SX]:
        """All symbols."""
        return {**self.symbols, **self.rates}

    def along(self, expr: ca.SX) -> ca.SX:
        """Time derivative of an expression of v and v_c0."""
        v, c, _, _ = self.all
        return ca.jtimes(expr, ca.vertcat(v, c), ca.vertcat(*self.rates.values()))


def sum_rule(flip: float) -> Statement:
    """Eq. (21): V1i' = z z' + f' + g'."""
    m = Moving()
    v, c, u1, u2 = m.all
    v_dot, c_dot = m.rates.values()
    parts = (
        (v - c) * (v_dot - c_dot)
        + m.along(barrier.f(v, u1, u2))
        + flip * m.along(barrier.g(c, u1, u2))
    )
    return Statement(m.names, (equal(m.along(m.V), parts),))


def barrier_rate(flip: float) -> Statement:
    """Eq. (22): f' where |v| > v_u2."""
    m = Moving()
    v, _, u1, u2 = m.all
    written = ca.if_else(
        barrier.h(v, u2), flip * barrier.sign(v) * m.rates["vdot"] / (u1 - ca.fabs(v)), 0
    )
    return Statement(m.names, (equal(m.along(barrier.f(v, u1, u2)), written),))


def x_rate(m: Moving) -> ca.SX:
    """v_c1' of one axis."""
    _, c, u1, u2 = m.all
    return target_rate(c, m.rates["cdot"], u1, u2)


def at_target(m: Moving) -> ca.SX:
    """[sgn(v_c1) v_c1'/(v_u1 - |v_c1|) where |v_c1| > v_u2], of Eqs. (23), (24)."""
    _, _, u1, u2 = m.all
    term = barrier.sign(m.x) * x_rate(m) / (u1 - ca.fabs(m.x))
    return ca.if_else(barrier.h(m.x, u2), term, 0)


def minimum_rate(flip: float) -> Statement:
    """Eq. (23): g' by the chain rule."""
    m = Moving()
    _, c, u1, u2 = m.all
    written = -(m.x - c) * (x_rate(m) - m.rates["cdot"]) - flip * at_target(m)
    return Statement(m.names, (equal(m.along(barrier.g(c, u1, u2)), written),))


def envelope(flip: float) -> Statement:
    """Eq. (24)."""
    m = Moving()
    return Statement(m.names, (equal((m.x - m.all[1]) * x_rate(m) + flip * at_target(m)),))


def g_rate(sign: float) -> Statement:
    """Eq. (25), with sign +1 as corrected."""
    m = Moving()
    _, c, u1, u2 = m.all
    return Statement(
        m.names, (equal(m.along(barrier.g(c, u1, u2)), sign * (m.x - c) * m.rates["cdot"]),)
    )


def per_axis(flip: float) -> Statement:
    """Eq. (28)."""
    m = Moving()
    v_dot, c_dot = m.rates.values()
    return Statement(m.names, (equal(m.along(m.V), m.A * v_dot - flip * m.w * c_dot),))


def both_axes(flip: float) -> Statement:
    """Eq. (26). Left: the derivative of the sum of both; right: A' v' - (v - v_c1)' v_c0'."""
    m, n = Moving("1"), Moving("2")
    columns = [ca.vertcat(x, y) for x, y in zip(m.all, n.all, strict=True)]
    point = ca.vertcat(*m.all[:2], *n.all[:2])
    rate = ca.jtimes(
        total_barrier(*columns), point, ca.vertcat(*m.rates.values(), *n.rates.values())
    )
    terms = [a.A * a.rates[f"vdot{a.suffix}"] - a.w * a.rates[f"cdot{a.suffix}"] for a in (m, n)]
    return Statement({**m.names, **n.names}, (equal(rate, terms[0] + flip * terms[1]),))


def split(flip: float) -> Statement:
    """Eq. (27)."""
    m, n = Moving("1"), Moving("2")
    columns = [ca.vertcat(x, y) for x, y in zip(m.all, n.all, strict=True)]
    point = ca.vertcat(*m.all[:2], *n.all[:2])
    rate = ca.jtimes(
        total_barrier(*columns), point, ca.vertcat(*m.rates.values(), *n.rates.values())
    )
    return Statement({**m.names, **n.names}, (equal(rate, m.along(m.V) + flip * n.along(n.V)),))


def decay(sign: float, axis: int = 0) -> Statement:
    """Eqs. (29), (30): V1i' + sign rho_i V1i = 0 for the law's own graph in the model's dynamics.

    V1i is the paper's; the force is the System's, with v_c0 and v_c0' free.
    """
    law = LawGraph("mb")
    k, t = axis + 1, law.symbols
    v = t[("v1", "omega")[axis]]
    u1, u2, rho = t[f"limits.v_u1[{k}]"], t[f"limits.v_u2[{k}]"], t[f"gains.mb.rho[{k}]"]
    free = symbols("c cdot")
    mass, friction = law.own(law.sample.mass), law.own(law.sample.friction)
    v_dot = acceleration(mass, law.force, friction)[axis]
    value = barrier.lyapunov(v, free["c"], u1, u2)
    rate = ca.jtimes(value, ca.vertcat(v, free["c"]), ca.vertcat(v_dot, free["cdot"]))
    return Statement({**t, **free}, (equal(rate, -sign * rho * value),), (), law.inner(axis))


def literal_decay(sign: float) -> Statement:
    """Eq. (29) for the command of (9) as printed, where A is not 0."""
    m = Moving()
    v, c, _, _ = m.all
    rho, c_dot = ca.SX.sym("rho"), m.rates["cdot"]
    command = (-rho * m.V + m.w * c_dot) / m.A
    rate = ca.jtimes(m.V, ca.vertcat(v, c), ca.vertcat(command, c_dot))
    return Statement({**m.names, "rho": rho}, (equal(rate, -sign * rho * m.V),))


def command(flip: float, axis: int = 0) -> Statement:
    """Eq. (9) times A: A F = M (-rho V1i + (v - v_c1) v_c0') + A F1, on the law's graph."""
    law = LawGraph("mb")
    k, t = axis + 1, law.symbols
    v, u1, u2 = t[("v1", "omega")[axis]], t[f"limits.v_u1[{k}]"], t[f"limits.v_u2[{k}]"]
    free = symbols("c cdot")
    c = free["c"]
    mass, friction = (law.own(item)[axis] for item in (law.sample.mass, law.sample.friction))
    a, value = barrier.a_term(v, c, u1, u2), barrier.lyapunov(v, c, u1, u2)
    bracket = (
        -t[f"gains.mb.rho[{k}]"] * value + flip * (v - barrier.minimiser(c, u1, u2)) * free["cdot"]
    )
    goal = equal(a * law.force[axis], mass * bracket + a * friction)
    return Statement({**t, **free}, (goal,), (), law.inner(axis))


def quotient_at_kink(flip: float) -> Statement:
    """The change of V1i over a short time h from v = v_u2, with the command at the start held."""
    m = Moving()
    v, c, u1, u2 = m.all
    t = {**m.names, **symbols("rho h")}
    command = (-t["rho"] * m.V + flip * m.w * t["cdot"]) / m.A
    later = barrier.lyapunov(v + t["h"] * command, c + t["h"] * t["cdot"], u1, u2)
    change = (later - m.V) / t["h"]
    given = (*m.inside, equal(v, u2), above(t["h"]), at_least(1, 1000000 * t["h"]), above(t["rho"]))
    del t["vdot"]
    return Statement(t, (at_least(1, ca.fabs(change + t["rho"] * m.V)),), given)
