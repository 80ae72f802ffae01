"""The barrier function in time: Eqs. (9), (21)-(30), on the functions and on the law's graph."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.laws import barrier
from wmr_ctrl.laws.analysis import target_rate, total_barrier
from wmr_ctrl.model.dynamics import acceleration
from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claim import CORRECTED, OURS, PRINTED, Claim
from wmr_ctrl.proofs.claims.common import CLOSED_FORM, NO_SERIES, OFF_EDGES, BarrierAxis, LawGraph
from wmr_ctrl.proofs.claims.pairs import law_cases, paired_cases
from wmr_ctrl.proofs.methods.spec import Refute, Ring
from wmr_ctrl.proofs.regions import Axis, open_cases, target_cases
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols


class Moving(BarrierAxis):
    """One axis with the rates of v and v_c0."""

    @property
    def rates(self) -> dict[str, ca.SX]:
        """v' and v_c0', made once."""
        if not hasattr(self, "_rates"):
            object.__setattr__(self, "_rates", symbols(f"vdot{self.suffix} cdot{self.suffix}"))
        found: dict[str, ca.SX] = getattr(self, "_rates")  # noqa: B009
        return found

    @property
    def names(self) -> dict[str, ca.SX]:
        """All symbols."""
        return {**self.symbols, **self.rates}

    def along(self, expr: ca.SX) -> ca.SX:
        """Time derivative of an expression of v and v_c0."""
        v, c, _, _ = self.all
        return ca.jtimes(expr, ca.vertcat(v, c), ca.vertcat(*self.rates.values()))


def _sum_rule(flip: float) -> Statement:
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


def _barrier_rate(flip: float) -> Statement:
    """Eq. (22): f' where |v| > v_u2."""
    m = Moving()
    v, _, u1, u2 = m.all
    written = ca.if_else(
        barrier.h(v, u2), flip * barrier.sign(v) * m.rates["vdot"] / (u1 - ca.fabs(v)), 0
    )
    return Statement(m.names, (equal(m.along(barrier.f(v, u1, u2)), written),))


def _x_rate(m: Moving) -> ca.SX:
    _, c, u1, u2 = m.all
    return target_rate(c, m.rates["cdot"], u1, u2)


def _at_target(m: Moving) -> ca.SX:
    """[sgn(v_c1) v_c1'/(v_u1 - |v_c1|) where |v_c1| > v_u2], of Eqs. (23), (24)."""
    _, _, u1, u2 = m.all
    term = barrier.sign(m.x) * _x_rate(m) / (u1 - ca.fabs(m.x))
    return ca.if_else(barrier.h(m.x, u2), term, 0)


def _minimum_rate(flip: float) -> Statement:
    """Eq. (23): g' by the chain rule."""
    m = Moving()
    _, c, u1, u2 = m.all
    written = -(m.x - c) * (_x_rate(m) - m.rates["cdot"]) - flip * _at_target(m)
    return Statement(m.names, (equal(m.along(barrier.g(c, u1, u2)), written),))


def _envelope(flip: float) -> Statement:
    """Eq. (24)."""
    m = Moving()
    return Statement(m.names, (equal((m.x - m.all[1]) * _x_rate(m) + flip * _at_target(m)),))


def _g_rate(sign: float) -> Statement:
    """Eq. (25), with sign +1 as corrected."""
    m = Moving()
    _, c, u1, u2 = m.all
    return Statement(
        m.names, (equal(m.along(barrier.g(c, u1, u2)), sign * (m.x - c) * m.rates["cdot"]),)
    )


def _per_axis(flip: float) -> Statement:
    """Eq. (28)."""
    m = Moving()
    v_dot, c_dot = m.rates.values()
    return Statement(m.names, (equal(m.along(m.V), m.A * v_dot - flip * m.w * c_dot),))


def _both_axes(flip: float) -> Statement:
    """Eq. (26). Left: the derivative of the sum of both; right: A' v' - (v - v_c1)' v_c0'."""
    m, n = Moving("1"), Moving("2")
    columns = [ca.vertcat(x, y) for x, y in zip(m.all, n.all, strict=True)]
    point = ca.vertcat(*m.all[:2], *n.all[:2])
    rate = ca.jtimes(
        total_barrier(*columns), point, ca.vertcat(*m.rates.values(), *n.rates.values())
    )
    terms = [a.A * a.rates[f"vdot{a.suffix}"] - a.w * a.rates[f"cdot{a.suffix}"] for a in (m, n)]
    return Statement({**m.names, **n.names}, (equal(rate, terms[0] + flip * terms[1]),))


def _split(flip: float) -> Statement:
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


def _literal_decay(sign: float) -> Statement:
    """Eq. (29) for the command of (9) as printed, where A is not 0."""
    m = Moving()
    v, c, _, _ = m.all
    rho, c_dot = ca.SX.sym("rho"), m.rates["cdot"]
    command = (-rho * m.V + m.w * c_dot) / m.A
    rate = ca.jtimes(m.V, ca.vertcat(v, c), ca.vertcat(command, c_dot))
    return Statement({**m.names, "rho": rho}, (equal(rate, -sign * rho * m.V),))


def _command(flip: float, axis: int = 0) -> Statement:
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


def _quotient_at_kink(flip: float) -> Statement:
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


ONE, TWO = Axis("1"), Axis("2")
OPEN35, PAIRS = Ring(open_cases()), Ring(paired_cases(ONE, TWO), spare=12)
TARGETS7 = Ring(target_cases(edges=False))
LAW = tuple(Ring(law_cases(open_cases(), axis), CLOSED_FORM) for axis in (0, 1))
NONZERO = tuple(c for c in open_cases() if c.label != "v_c0 zero, v zero")
NOMINAL = OFF_EDGES + "; model exact, no disturbance, |v| below the clip" + NO_SERIES
KINK = (at(v="4/5", c="1/2", u1=1, u2="4/5", cdot=5, rho=15, h="1/1000000"),)
R2_POINT = (at(v=0, c=2, u1=1, u2="4/5", cdot=1),)

CLAIMS = (
    Claim(
        "eq21",
        (21,),
        PRINTED,
        "V1i' = z z' + f' + g', term by term",
        "Where the change of the barrier function comes from.",
        OFF_EDGES,
        _sum_rule,
        OPEN35,
    ),
    Claim(
        "eq22",
        (22,),
        PRINTED,
        "f' = sgn(v) v'/(v_u1 - |v|) where |v| > v_u2, else 0",
        "The barrier term resists only near the limit.",
        OFF_EDGES,
        _barrier_rate,
        OPEN35,
    ),
    Claim(
        "eq23",
        (23,),
        PRINTED,
        "g' = -(v_c1 - v_c0)(v_c1' - v_c0') - [sgn(v_c1) v_c1'/(v_u1 - |v_c1|)]",
        "How the reference value moves with the target.",
        OFF_EDGES,
        _minimum_rate,
        TARGETS7,
    ),
    Claim(
        "eq24",
        (24,),
        PRINTED,
        "(v_c1 - v_c0) v_c1' + [sgn(v_c1) v_c1'/(v_u1 - |v_c1|)] = 0",
        "At the best velocity a small change of it costs nothing.",
        OFF_EDGES,
        _envelope,
        TARGETS7,
    ),
    Claim(
        "eq25.printed",
        (25,),
        PRINTED,
        "g' = -(v_c1 - v_c0) v_c0'",
        "The sign is wrong wherever the target "
        "velocity is not v_c0 itself, that is whenever the limit matters.",
        OFF_EDGES,
        lambda s: _g_rate(-s),
        Refute(R2_POINT),
    ),
    Claim(
        "eq25",
        (25,),
        CORRECTED,
        "g' = +(v_c1 - v_c0) v_c0'",
        "With this sign (26) follows, as the paper needs.",
        OFF_EDGES,
        _g_rate,
        TARGETS7,
    ),
    Claim(
        "eq26",
        (26,),
        PRINTED,
        "V1' = A' v' - (v - v_c1)' v_c0', both axes together (it follows from the "
        "corrected (25), not from the printed one)",
        "What the law can do about the barrier function, and what the moving target does to it.",
        OFF_EDGES,
        _both_axes,
        PAIRS,
    ),
    Claim(
        "eq27",
        (27,),
        PRINTED,
        "V1' = V11' + V12'",
        "The axes do not interfere.",
        OFF_EDGES,
        _split,
        PAIRS,
    ),
    Claim(
        "eq28",
        (28,),
        PRINTED,
        "V1i' = A_i v_i' - (v_i - v_c1i) v_c0i', all 35 regions of v and v_c0",
        "Each axis by itself.",
        OFF_EDGES,
        _per_axis,
        OPEN35,
    ),
    Claim(
        "eq09",
        (9,),
        PRINTED,
        "A (F - F1) = M1 (-rho V1i + (v - v_c1) v_c0') for the model-based law's own graph, "
        "linear axis",
        "The compiled law is the paper's, only evaluated without dividing by A.",
        NOMINAL,
        _command,
        LAW[0],
    ),
    Claim(
        "eq09.angular",
        (9,),
        PRINTED,
        "the same on the angular axis",
        "The compiled law is the paper's.",
        NOMINAL,
        lambda s: _command(s, 1),
        LAW[1],
    ),
    Claim(
        "eq29.printed",
        (29,),
        PRINTED,
        "V1i' = +rho V1i, as the paper's text reads",
        "Read literally the velocity error would grow. The missing minus may be a misprint of the "
        "text at hand.",
        OFF_EDGES + "; A != 0",
        lambda s: _literal_decay(-s),
        Ring(NONZERO),
    ),
    Claim(
        "eq29",
        (29,),
        CORRECTED,
        "V1i' = -rho V1i under (9), where A is not 0",
        "The distance to the target velocity, measured by the barrier function, shrinks at the "
        "chosen rate.",
        OFF_EDGES + "; A != 0",
        _literal_decay,
        Ring(NONZERO),
    ),
    Claim(
        "eq30.law",
        (29, 30),
        OURS,
        "V1i' = -rho_i V1i for the compiled model-based law, linear axis, A = 0 included",
        "The law that runs on the robot has the property of the theorem, not just the formula on "
        "paper.",
        NOMINAL,
        decay,
        LAW[0],
    ),
    Claim(
        "eq30.law-angular",
        (29, 30),
        OURS,
        "the same on the angular axis",
        "As on the linear axis.",
        NOMINAL,
        lambda s: decay(s, 1),
        LAW[1],
    ),
    Claim(
        "eq30.printed",
        (30,),
        PRINTED,
        "V1' = -rho V1 at every instant, |v| = v_u2 included",
        "Exactly where the barrier begins, the acceleration that the law computes makes the "
        "barrier function rise "
        "for an instant (here at 13 1/s instead of falling). It holds at almost every instant, "
        "which is enough "
        "for the decay.",
        "|v| = v_u2; change of V1i over at most 1 microsecond compared with -rho V1i, tolerance 1",
        _quotient_at_kink,
        Refute(KINK),
    ),
    Claim(
        "eq30",
        (30,),
        CORRECTED,
        "V1(t) = V1(0) exp(-rho t): (30) at almost every t, V1 continuous",
        "The decay of the theorem is right in spite of the corner.",
        "model exact, no disturbance, one rho for both axes (else the slower one bounds V1)",
        verdict="HAND",
        uses=("eq29", "lemma.almost-everywhere"),
    ),
)
