"""Why the barrier function works: proximal map, Moreau envelope, Bregman distance (P1-P8)."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.barrier import paper as barrier
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.common import (
    ALL_LIMITS,
    CLOSED_FORM,
    FINITE,
    NO_SERIES,
    OFF_EDGES,
    BarrierAxis,
    LawGraph,
)
from wmr_ctrl.proofs.methods.spec import Z3, Ring
from wmr_ctrl.proofs.regions import all_cases, target_cases
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols


def _bregman(flip: float) -> Statement:
    """P1: V1i - w^2/2 is the Bregman distance of f with the subgradient v_c0 - v_c1, and >= 0."""
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    distance = barrier.f(v, u1, u2) - barrier.f(a.x, u1, u2) - flip * (c - a.x) * a.w
    return Statement(a.symbols, (equal(a.V - 0.5 * a.w**2, distance), at_least(distance)))


def _subgradient(flip: float) -> Statement:
    """f(y) >= f(v_c1) + (v_c0 - v_c1)(y - v_c1) for every y (here v): v_c1 = prox_f(v_c0)."""
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    line = barrier.f(a.x, u1, u2) + flip * (c - a.x) * (v - a.x)
    return Statement(a.symbols, (at_least(barrier.f(v, u1, u2), line),))


def _envelope_slope(flip: float) -> Statement:
    a = BarrierAxis()
    _, c, u1, u2 = a.all
    return Statement(a.symbols, (equal(ca.gradient(barrier.g(c, u1, u2), c), a.x - flip * c),))


def _three_points(flip: float) -> Statement:
    a = BarrierAxis()
    share = 0.5 if flip > 0 else 0.75
    return Statement(a.symbols, (at_least(a.A * a.w, a.V + share * a.w**2),))


def _q_range(flip: float) -> Statement:
    a = BarrierAxis()
    top = 1 if flip > 0 else 0.5
    return Statement(a.symbols, (at_least(a.stable.q), at_least(top, a.stable.q)))


def _q_positive(flip: float) -> Statement:
    a = BarrierAxis()
    return Statement(a.symbols, (above(flip * a.stable.q),))


def _quotient_range(flip: float) -> Statement:
    """P5 without dividing by w: 0 <= (V1/A) w <= w^2."""
    a = BarrierAxis()
    top = 1 if flip > 0 else 0.5
    product = a.stable.V1_over_A * a.stable.w
    return Statement(a.symbols, (at_least(product), at_least(top * a.stable.w**2, product)))


def _target_slope(flip: float) -> Statement:
    """P6: dv_c1/dv_c0 is 1, 0 or 1/(1 + 1/d^2), between 0 and 1."""
    a = BarrierAxis()
    _, c, u1, u2 = a.all
    slope = ca.gradient(a.x, c)
    edge = u2 + 1 / (u1 - u2)
    far = 1 / (1 + flip / (u1 - ca.fabs(a.x)) ** 2)
    written = ca.if_else(ca.fabs(c) <= u2, 1, ca.if_else(ca.fabs(c) <= edge, 0, far))
    return Statement(a.symbols, (equal(slope, written), at_least(slope), at_least(1, slope)))


def _q_at_target(flip: float) -> Statement:
    """P7: q at v = v_c1 is dv_c1/dv_c0, so that the feed-forward becomes the target's own rate."""
    a = BarrierAxis()
    v, c, _, _ = a.all
    q = ca.substitute(a.stable.q, v, a.x)
    return Statement(a.symbols, (equal(q, ca.gradient(a.x, c) + (0 if flip > 0 else c)),))


def _bounded_command(flip: float) -> Statement:
    """P8 on the law's graph: |F - F1|/M <= rho |w| + |v_c0'|, given P4 and P5 inside it."""
    law = LawGraph("mb")
    names = {n: law.symbols[n] for n in ("gains.mb.rho[1]", "model.m", "model.I")}
    t = {**names, **symbols("quotient q w cdot friction")}
    rho, mass = names["gains.mb.rho[1]"], names["model.m"]
    force = law.force[0] - t["friction"]
    axis = law.sample.barrier[0]
    inner = {
        "quotient": law.own(axis.V1_over_A),
        "q": law.own(axis.q),
        "cdot": law.own(law.sample.v_c0_dot)[0],
        "friction": law.own(law.sample.friction)[0],
    }
    given = (
        above(rho),
        above(mass),
        at_least(t["q"]),
        at_least(1, t["q"]),
        at_least(t["quotient"] * t["w"]),
        at_least(t["w"] ** 2, t["quotient"] * t["w"]),
        at_least(t["w"] ** 2, t["quotient"] ** 2),
    )
    bound = flip * rho * ca.fabs(t["w"]) + ca.fabs(t["cdot"])
    return Statement(t, (at_least(bound * mass, ca.fabs(force)),), given, inner)


AT_TARGET = tuple(c for c in target_cases(edges=False))
NO_CORNER = tuple(c for c in all_cases() if "middle" not in c.label and "edge" not in c.label)

CLAIMS = (
    Claim(
        "P1",
        (12, 81),
        OURS,
        "V1i = w^2/2 + D_f(v, v_c1), the Bregman distance of f, which is >= 0; w = v - v_c1",
        "The barrier function is a squared distance plus something that only grows towards the "
        "limit.",
        ALL_LIMITS,
        _bregman,
        Ring(all_cases(), log_lemma=True),
        premises=("lemma.log",),
    ),
    Claim(
        "P1.prox",
        (16, 18),
        OURS,
        "v_c0 - v_c1 is a subgradient of f at v_c1: v_c1 is the proximal map of f, and "
        "-g its Moreau envelope",
        "The target velocity is a smooth clip of v_c0 to the limit, of the kind known "
        "from optimisation.",
        ALL_LIMITS,
        _subgradient,
        Ring(all_cases(), log_lemma=True),
        premises=("lemma.log",),
    ),
    Claim(
        "P2",
        (16, 25),
        OURS,
        "dg/dv_c0 = v_c1 - v_c0",
        "The corrected sign of (25), without time.",
        OFF_EDGES,
        _envelope_slope,
        Ring(target_cases(edges=False)),
    ),
    Claim(
        "P3",
        (10, 12),
        OURS,
        "A w >= V1i + w^2/2",
        "Slope and value of the barrier function keep in step.",
        ALL_LIMITS,
        _three_points,
        Ring(all_cases(), log_lemma=True),
        premises=("lemma.log",),
    ),
    Claim(
        "P4",
        (9, 10),
        OURS,
        "0 <= q <= 1 for the compiled q = (v - v_c1)/A",
        "The feed-forward is never amplified.",
        ALL_LIMITS + FINITE,
        _q_range,
        Ring(all_cases()),
    ),
    Claim(
        "P4.positive",
        (9, 10),
        OURS,
        "q > 0 outside the middle region (0 there only in the limit v -> v_c1)",
        "The feed-forward never has the wrong sign.",
        "|v_c0| <= v_u2 or |v_c0| > v_u2 + 1/(v_u1 - v_u2)" + FINITE,
        _q_positive,
        Ring(NO_CORNER),
    ),
    Claim(
        "P5",
        (9, 12),
        OURS,
        "V1i/A_i as compiled lies between 0 and v - v_c1",
        "The feedback never overshoots "
        "what the distance to the target asks for: near the limit it stays bounded, it does not "
        "blow up.",
        ALL_LIMITS + NO_SERIES,
        _quotient_range,
        Ring(all_cases(), CLOSED_FORM, log_lemma=True),
        premises=("lemma.log",),
    ),
    Claim(
        "P6",
        (18,),
        OURS,
        "dv_c1/dv_c0 = 1, 0 or 1/(1 + 1/(v_u1 - |v_c1|)^2): between 0 and 1",
        "The target velocity never moves faster than v_c0.",
        OFF_EDGES,
        _target_slope,
        Ring(target_cases(edges=False)),
    ),
    Claim(
        "P7",
        (9, 18),
        OURS,
        "at v = v_c1 the compiled q equals dv_c1/dv_c0",
        "On target, the law tells the robot to follow the target's own acceleration.",
        OFF_EDGES + FINITE,
        _q_at_target,
        Ring(target_cases(edges=False)),
    ),
    Claim(
        "P8",
        (9,),
        OURS,
        "|commanded acceleration| <= rho |v - v_c1| + |v_c0'| on the law's graph",
        "The command stays bounded right up to the speed limit; this barrier does not push "
        "infinitely hard.",
        "P4 and P5 for the inner values",
        _bounded_command,
        Z3(),
        premises=("P4", "P5"),
    ),
)
