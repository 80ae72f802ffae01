"""Ours: the constant disturbance that the paper's barrier withstands, d_max = rho max V1i/A_i."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial

from casadi import gradient, if_else, log

from wmr_proofs import paper_barrier as barrier
from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Ball, Point, Ring, Table
from wmr_proofs.paper_functions import authority_limit
from wmr_proofs.regions import at, axis_case, off_target_cases, open_cases
from wmr_proofs.statement import Statement, equal, symbols

from . import authority_table as table
from .common import BarrierAxis, barrier_axis

LIMIT_BOX = {"s": (Fraction("1e-300"), Fraction("0.99"))}
LIMIT_CUTS = {"s": [Fraction(f"1e-{k}") for k in (120, 40, 12, 6, 4, 3, 2, 1)]}

AXES = rows(axis=(0, 1), name=("linear", "angular"), unit=("m/s^2", "rad/s^2"))
claim = Claims(given="{AUTHORITY_PAPER}")


def of_axis(points: Callable[[int], Sequence[Point]]) -> Callable[[int], Table]:
    """Method of a claim: these points of its axis."""
    return lambda axis: Table(points=partial(points, axis))


@claim(
    "authority.falls", (9,), by=Ring(off_target_cases(), log_lemma=True), premises="P3 lemma.log"
)
def falls_with_target(mutation: Mutation) -> Statement:
    """V1/A falls as v_c0 rises: its derivative times A^2 is V1 - A w <= -w^2/2.

    The larger the tracking error, the weaker the barrier.

    Given: {OFF_EDGES}; v_c0 >= 0, v != v_c1 (A != 0).
    """
    a = BarrierAxis()
    slope = gradient(a.V / a.A, a.all[1]) * a.A**2
    return a.states(slope == mutation * a.V - a.w * a.A, -0.5 * a.w**2 >= slope)


@claim("authority.rises", (74, 75), by=Ring(open_cases()))
def rises(mutation: Mutation) -> Statement:
    """V1 and A rise with v beyond v_c1.

    Used to bound V1/A between two velocities.

    Given: {OFF_EDGES}.
    """
    a, v, _, _, _ = barrier_axis()
    return a.states(gradient(a.V, v) == a.A, gradient(a.A, v) >= mutation(1, 2))


@claim("authority.lower-{name}", (9,), by=of_axis(table.low_points), over=AXES)
def low(mutation: Mutation) -> Statement:
    """on the {name} axis rho V1/A reaches the tabulated lower bound of d_max for each tabulated
    v_c0 from 0 to 20.

    The law withstands a disturbance up to the bound [{unit}] before the limit.
    """
    a = BarrierAxis()
    t = a | symbols("rho low", "rho")
    return Statement(t, (t.rho * a.V >= mutation(t.low, 1.01 * t.low) * a.A, a.A > 0), a.inside)


@claim(
    "authority.upper-{name}",
    (9,),
    by=of_axis(table.high_points),
    premises="authority.rises authority.links-{name} P5",
    over=AXES,
)
def high(mutation: Mutation) -> Statement:
    """on the {name} axis, v_c0 at each of the tabulated values from 0 to 20, rho V1/A does not
    exceed the tabulated upper bound: on each [a, b] of a chain of intervals it is at most rho
    V1(b)/A(a).

    A larger constant disturbance pushes the robot over its limit in spite of the law.

    Given: {AUTHORITY_PAPER}; below v_c1 + bound/rho by P5; no gap by authority.links.
    """
    a, v, c, u1, u2 = barrier_axis()
    t = a | symbols("b rho high", "rho")
    later = barrier.lyapunov(t.b, c, u1, u2)
    goals = mutation(t.high, 0.99 * t.high) * a.A >= t.rho * later, a.A > 0
    return Statement(t, goals, (a.inside, t.b > v, u1 > t.b))


@claim("authority.links-{name}", (9,), by=of_axis(table.link_points), over=AXES)
def links(mutation: Mutation) -> Statement:
    """on the {name} axis each row's intervals leave no gap: the first begins at most bound/rho
    beyond v_c1, each further one at the end of the previous one, and the last ends at the clip.

    The table has no gap in v.
    """
    a, v, _, u1, _ = barrier_axis()
    t = a | symbols("b before first last rho high", "rho high")
    begin = if_else(t.first, a.x + t.high / t.rho, t.before)
    short = if_else(t.last, u1 - 1.01 * table.CLIP - t.b, 0)
    longer = t.b - v - mutation(0, 1)
    return Statement(t, (begin >= v, short <= 0, longer > 0))


@claim("authority.rows-{name}", (9,), given="", by=of_axis(table.row_points), over=AXES)
def rows_cover(mutation: Mutation) -> Statement:
    """on the {name} axis the rows' v_c0 rise from 0 to 20.

    The table has no gap in v_c0.
    """
    t = symbols("c before first last")
    end = if_else(t.last, t.c - table.LARGEST_TARGET * mutation(1, 1.01), 0)
    rise = if_else(t.first, 1, t.c - t.before)
    return Statement(t, (if_else(t.first, t.c, 0) == 0, end == 0, rise > 0))


@claim(
    "authority.98-{name}",
    (9,),
    by=of_axis(table.ratio_points),
    premises="authority.falls authority.rows-{name} authority.lower-{name} authority.upper-{name}",
    over=AXES,
)
def ratio(mutation: Mutation) -> Statement:
    """on the {name} axis, between any two neighbouring rows, the lower bound is at least 98 % of
    the upper one.

    The bound on the disturbance is known to two per cent for every |v_c0| <= 20.

    Given: V1/A falls with v_c0, so rows bracket what is between them.
    """
    t = symbols("low high")
    return Statement(t, 100 * t.low >= mutation(98, 99) * t.high)


@claim(
    "authority.shape",
    (9, 12),
    by=Ring(tuple(axis_case("", "far+", "out+", order) for order in ("<", ">"))),
)
def shape(mutation: Mutation) -> Statement:
    """beyond the middle region V1/A = d s (d^2 (1 - s)^2/2 - ln s - 1 + s)/((1 - s)(1 + d^2 s))
    with s = (v_u1 - v)/d, d = v_u1 - v_c1, and v_c0 - v_u1 = 1/d - d.

    The shape of the barrier's resistance far from the target.

    Given: v_c0 > v_u2 + 1/(v_u1 - v_u2), v > v_u2.
    """
    a, v, c, u1, _ = barrier_axis()
    d = u1 - a.x
    s = (u1 - v) / d
    return a.states(
        a.A * d * s == (1 - s) * (1 + mutation * d**2 * s),
        equal(a.V, 0.5 * d**2 * (1 - s) ** 2 - log(s) - (1 - s)),
        c - u1 == 1 / d - d,
    )


@claim(
    "authority.limit",
    (9,),
    by=Ball(box=LIMIT_BOX, cuts_at=LIMIT_CUTS),
    premises="authority.shape lemma.log",
)
def limit(mutation: Mutation) -> Statement:
    """s (s - 1 - ln s)/(1 - s) <= 0.2163 for 0 < s <= 0.99: as v_c0 grows, d_max tends to at most
    0.2163 rho/(v_c0 - v_u1).

    Far away, the barrier's authority fades like one over the distance.

    Given: d -> 0 in authority.shape; for s > 0.99 it is below 1 - s by ln t <= t - 1.
    """
    t = symbols("s")
    return Statement(t, mutation(0.2163, 0.2161) >= authority_limit(t.s))


@claim("authority.limit-reached", (9,), by=Table(points=lambda: (at(s="0.3162"),)))
def limit_reached(mutation: Mutation) -> Statement:
    """its maximum is at least 0.2161, so the limit is 0.216 rho/(v_c0 - v_u1) to three digits.

    The bound is attained.

    Given: s = 0.3162.
    """
    t = symbols("s")
    return Statement(t, authority_limit(t.s) >= mutation(0.2161, 0.2163))
