"""Ours: the constant disturbance that the paper's barrier withstands, d_max = rho max V1i/A_i."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import casadi as ca

from wmr_ctrl.barrier import paper as barrier
from wmr_ctrl.barrier.lyapunov import authority_limit
from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.authority_table import (
    CLIP,
    LARGEST_TARGET,
    high_points,
    link_points,
    low_points,
    ratio_points,
    row_points,
)  # fmt: skip
from wmr_ctrl.proofs.claims.common import OFF_EDGES, BarrierAxis
from wmr_ctrl.proofs.methods.spec import Ball, Ring, Table
from wmr_ctrl.proofs.regions import AxisName, off_target_cases, open_cases
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols


def _falls_with_target(flip: float) -> Statement:
    """d/dv_c0 (V1/A) A^2 = V1 - w A <= -w^2/2 <= 0 for c >= 0."""
    a = BarrierAxis()
    slope = ca.gradient(a.V / a.A, a.all[1]) * a.A**2
    return Statement(
        a.symbols, (equal(slope, flip * a.V - a.w * a.A), at_least(-0.5 * a.w**2, slope))
    )


def _rises(flip: float) -> Statement:
    """V1 and A rise with v from v_c1 on: dV1/dv = A >= w >= 0 and dA/dv >= 1."""
    a = BarrierAxis()
    v = a.all[0]
    rise = ca.gradient(a.A, v)
    return Statement(
        a.symbols, (equal(ca.gradient(a.V, v), a.A), at_least(rise, 1 if flip > 0 else 2))
    )


def _low(flip: float) -> Statement:
    a = BarrierAxis()
    t = {**a.symbols, **symbols("rho low", "rho")}
    bound = t["low"] if flip > 0 else 1.01 * t["low"]
    return Statement(t, (at_least(t["rho"] * a.V, bound * a.A), above(a.A)), a.inside)


def _high(flip: float) -> Statement:
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    t = {**a.symbols, **symbols("b rho high", "rho")}
    later = barrier.lyapunov(t["b"], c, u1, u2)
    bound = t["high"] if flip > 0 else 0.99 * t["high"]
    return Statement(
        t,
        (at_least(bound * a.A, t["rho"] * later), above(a.A)),
        (*a.inside, above(t["b"], v), above(u1, t["b"])),
    )


def _links(flip: float) -> Statement:
    """A row's links: the first begins at most high/rho beyond v_c1, the last ends at the clip."""
    a = BarrierAxis()
    v, _, u1, _ = a.all
    t = {**a.symbols, **symbols("b before first last rho high", "rho high")}
    begin = ca.if_else(t["first"], a.x + t["high"] / t["rho"], t["before"])
    short = ca.if_else(t["last"], u1 - 1.01 * CLIP - t["b"], 0)
    longer = t["b"] - v - (0 if flip > 0 else 1)
    return Statement(t, (at_least(begin, v), at_least(0, short), above(longer)))


def _rows_cover(flip: float) -> Statement:
    """The rows' v_c0 rise from 0 to the largest."""
    t = symbols("c before first last")
    begin = ca.if_else(t["first"], t["c"], 0)
    end = ca.if_else(t["last"], t["c"] - LARGEST_TARGET * (1 if flip > 0 else 1.01), 0)
    rise = ca.if_else(t["first"], 1, t["c"] - t["before"])
    return Statement(t, (equal(begin), equal(end), above(rise)))


def _ratio(flip: float) -> Statement:
    t = symbols("low high")
    share = 98 if flip > 0 else 99
    return Statement(t, (at_least(100 * t["low"], share * t["high"]),))


def _shape(flip: float) -> Statement:
    """Beyond the middle region, ahead: with s = gap/d, A d s = (1 - s)(1 + d^2 s) and
    V1 = d^2 (1 - s)^2/2 - ln s - (1 - s).
    """
    a = BarrierAxis()
    v, c, u1, _ = a.all
    d = u1 - a.x
    s = (u1 - v) / d
    value = 0.5 * d**2 * (1 - s) ** 2 - ca.log(s) - (1 - s)
    return Statement(
        a.symbols,
        (
            equal(a.A * d * s, (1 - s) * (1 + flip * d**2 * s)),
            equal(a.V, value),
            equal(c - u1, 1 / d - d),
        ),
    )


def _limit(flip: float) -> Statement:
    t = symbols("s")
    return Statement(t, (at_least(0.2163 if flip > 0 else 0.2161, authority_limit(t["s"])),))


def _limit_reached(flip: float) -> Statement:
    t = symbols("s")
    return Statement(t, (at_least(authority_limit(t["s"]), 0.2161 if flip > 0 else 0.2163),))


LIMIT_BOX = {"s": (Fraction("1e-300"), Fraction("0.99"))}
LIMIT_CUTS = {"s": [Fraction(f"1e-{k}") for k in (120, 40, 12, 6, 4, 3, 2, 1)]}
PAPER = "paper limits and gains, v_c0' = 0, |v| below the clip; mirrored for v_c0 < 0"


def _gaps(axis: int, name: str) -> tuple[Claim, Claim]:
    return (
        Claim(
            f"authority.links-{name}",
            (9,),
            OURS,
            f"on the {name} axis each row's intervals join: the first begins at most bound/rho "
            "beyond v_c1, each further one where the one before ends, the last ends at the clip",
            "The table has no gap in v.",
            PAPER,
            _links,
            Table(points=partial(link_points, axis)),
        ),
        Claim(
            f"authority.rows-{name}",
            (9,),
            OURS,
            f"on the {name} axis the rows' v_c0 rise from 0 to 20",
            "The table has no gap in v_c0.",
            "",
            _rows_cover,
            Table(points=partial(row_points, axis)),
        ),
    )


def _near(axis: int, name: str) -> Claim:
    return Claim(
        f"authority.98-{name}",
        (9,),
        OURS,
        f"on the {name} axis, between any two neighbouring rows, the lower bound "
        "is at least 98 % of the upper one",
        "The bound on the disturbance is known to two per cent for every |v_c0| <= 20.",
        "V1/A falls with v_c0, so rows bracket what is between them",
        _ratio,
        Table(points=partial(ratio_points, axis)),
        premises=(
            "authority.falls",
            f"authority.rows-{name}",
            f"authority.lower-{name}",
            f"authority.upper-{name}",
        ),
    )


def _table(axis: int) -> tuple[Claim, ...]:
    name, unit = ("linear", "m/s^2") if axis == 0 else ("angular", "rad/s^2")
    return (
        Claim(
            f"authority.lower-{name}",
            (9,),
            OURS,
            f"on the {name} axis rho V1/A reaches the tabulated lower bounds of "
            "d_max, v_c0 at each of the tabulated values from 0 to 20",
            f"A disturbance up to the bound [{unit}] is held back before the limit.",
            PAPER,
            _low,
            Table(points=partial(low_points, axis)),
        ),
        Claim(
            f"authority.upper-{name}",
            (9,),
            OURS,
            f"on the {name} axis, v_c0 at each of the tabulated values from 0 to 20, rho V1/A "
            "does not exceed the tabulated upper bound: on each [a, b] of a chain of intervals it "
            "is at most rho V1(b)/A(a)",
            "A larger constant disturbance pushes the robot over its limit, whatever the law does.",
            PAPER + "; below v_c1 + bound/rho by P5; no gap by authority.links",
            _high,
            Table(points=partial(high_points, axis)),
            premises=("authority.rises", f"authority.links-{name}", "P5"),
        ),
        *_gaps(axis, name),
        _near(axis, name),
    )


CLAIMS = (
    Claim(
        "authority.falls",
        (9,),
        OURS,
        "V1/A falls as v_c0 rises: its derivative times A^2 is V1 - A w <= -w^2/2",
        "The farther the robot is from where it should be, the weaker the barrier.",
        OFF_EDGES + "; v_c0 >= 0, v != v_c1 (A != 0)",
        _falls_with_target,
        Ring(off_target_cases(), log_lemma=True),
        premises=("P3", "lemma.log"),
    ),
    Claim(
        "authority.rises",
        (74, 75),
        OURS,
        "V1 and A rise with v beyond v_c1",
        "Used to bound V1/A between two velocities.",
        OFF_EDGES,
        _rises,
        Ring(open_cases()),
    ),
    *_table(0),
    *_table(1),
    Claim(
        "authority.shape",
        (9, 12),
        OURS,
        "beyond the middle region V1/A = d s (d^2 (1 - s)^2/2 - ln s - 1 + s)/((1 - s)"
        "(1 + d^2 s)) with s = (v_u1 - v)/d, d = v_u1 - v_c1, and v_c0 - v_u1 = 1/d - d",
        "The shape of the barrier's resistance far from the target.",
        "v_c0 > v_u2 + 1/(v_u1 - v_u2), v > v_u2",
        _shape,
        Ring(tuple(AxisName().case("far+", "out+", order) for order in ("<", ">"))),
    ),
    Claim(
        "authority.limit",
        (9,),
        OURS,
        "s (s - 1 - ln s)/(1 - s) <= 0.2163 for 0 < s <= 0.99: as v_c0 grows, d_max tends "
        "to at most 0.2163 rho/(v_c0 - v_u1)",
        "Far away, the barrier's authority fades like one over the distance.",
        "d -> 0 in authority.shape; for s > 0.99 it is below 1 - s by ln t <= t - 1",
        _limit,
        Ball(box=LIMIT_BOX, cuts_at=LIMIT_CUTS),
        premises=("authority.shape", "lemma.log"),
    ),
    Claim(
        "authority.limit-reached",
        (9,),
        OURS,
        "its maximum is at least 0.2161, so the limit is 0.216 rho/(v_c0 - v_u1) to three digits",
        "The bound is attained.",
        "s = 0.3162",
        _limit_reached,
        Table(points=lambda: (at(s="0.3162"),)),
    ),
    Claim(
        "authority.meaning",
        (9,),
        OURS,
        "a constant disturbance d <= rho max V1/A, met from v <= v_c1 with v_c0 held, never "
        "carries |v| to the limit; any larger one does",
        "The paper's theorem has no disturbance; this is what its barrier really withstands.",
        "model exact, v_c0' = 0",
        verdict="HAND",
        premises=("authority.lower-linear", "authority.upper-linear", "lemma.comparison"),
    ),
)
