"""The regions of `proofs.regions` cover everything, and each chart reaches all of its region."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from wmr_ctrl.barrier import paper as barrier
from wmr_ctrl.barrier.smooth import SmoothAxis
from wmr_ctrl.proofs import regions
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.common import BarrierAxis
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, equal


def _bounds(u2: ca.SX, b: ca.SX) -> dict[str, tuple[ca.SX | None, ca.SX | None]]:
    """Open interval of each region's size; None: no bound."""
    edge = u2 + 1 / b
    return {
        "near": (ca.SX(0), u2),
        "middle": (u2, edge),
        "far": (edge, None),
        "beyond": (u2, None),
        "in": (ca.SX(0), u2),
        "out": (u2, u2 + b),
    }


def _inside(size: ca.SX, region: str, u2: ca.SX, b: ca.SX) -> ca.SX:
    points = {"zero": ca.SX(0), "corner": u2, "edge": u2 + 1 / b, "kink": u2}
    if region in points:
        return ca.eq(size, points[region])
    low, high = _bounds(u2, b)[region]
    assert low is not None
    return size > low if high is None else ca.logic_and(size > low, size < high)


def _member(value: ca.SX, name: str, u2: ca.SX, b: ca.SX) -> ca.SX:
    """Whether ``value`` lies in a signed region such as ``middle-``."""
    if name == "zero":
        return ca.eq(value, 0)
    size = -value if name.endswith("-") else value
    return _inside(size, name[:-1], u2, b)


def _cover(names: tuple[str, ...], index: int) -> Callable[[float], Statement]:
    def statement(flip: float) -> Statement:
        a = BarrierAxis()
        _, _, u1, u2 = a.all
        listed = names if flip > 0 else names[1:]
        hit = _member(a.all[index], listed[0], u2, u1 - u2)
        for name in listed[1:]:
            hit = ca.logic_or(hit, _member(a.all[index], name, u2, u1 - u2))
        return Statement(a.symbols, (above(ca.if_else(hit, 1, 0)),), a.inside)

    return statement


def _reached(flip: float) -> Statement:
    """n = y/(1 - y) > 0 with n/(1 + n) = y for every 0 < y < 1."""
    t = {"y": ca.SX.sym("y")}
    y = t["y"]
    n = y / (1 - y)
    return Statement(t, (above(n), equal(n / (1 + n), flip * y)), (above(y), above(1, y)))


def _charted(flip: float) -> Statement:
    """The charts themselves at n = y/(1 - y) run from one end of each interval to the other."""
    t = {name: ca.SX.sym(name) for name in ("y", "u2", "b")}
    y, u2, b = t.values()
    n = y / (1 - y)
    goals: list[Relation] = []
    for name, value in (
        ("near+", regions.target_value),
        ("middle+", regions.target_value),
        ("in+", regions.side_value),
        ("out+", regions.side_value),
    ):
        low, high = _bounds(u2, b)[name[:-1]]
        assert low is not None
        assert high is not None
        goals.append(equal(value(name, u2, b, n), low + flip * y * (high - low)))
    return Statement(t, tuple(goals), (above(y), above(1, y), above(u2), above(b)))


def _far_reached(flip: float) -> Statement:
    """For |v_c0| > v_u2 + 1/b the gap d of the compiled formula lies in (0, b), and the chart at it
    gives v_c0 back: target_value("far+") with d = b/(1 + j).
    """
    a = BarrierAxis()
    _, c, u1, u2 = a.all
    b = u1 - u2
    d = u1 - barrier.minimiser(c, u1, u2)
    goals = (above(d), above(b, d), equal(u1 - d + flip / d, c))
    return Statement(a.symbols, goals, (*a.inside, above((c - u2) * b, 1), above(c, u2 + 1 / b)))


def _beyond_reached(flip: float) -> Statement:
    """The same beyond v_u2 for the smooth barrier: target_value("beyond+") with d = b/(1 + j)."""
    a = BarrierAxis()
    v, c, u1, u2 = a.all
    b, d = u1 - u2, SmoothAxis(c, v, u1, u2).d
    goals = (above(d), above(b, d), equal(u1 - d + flip / d - 1 / b, c))
    return Statement(a.symbols, goals, (*a.inside, above(c, u2), above(1e100, c)))


def _ordered(flip: float) -> Statement:
    """Two numbers i, j > 0 are equal, or i = j + m, or i = j m/(1 + m), with m > 0."""
    t = {name: ca.SX.sym(name) for name in ("i", "j")}
    i, j = t.values()
    more, less = i - j, i / (j - i)
    rest = ca.if_else(
        i > j,
        ca.fabs(j + more - i),
        ca.if_else(i < j, ca.fabs(j * less / (1 + less) - flip * i), 0),
    )
    sign = ca.if_else(i > j, more, ca.if_else(i < j, less, 1))
    return Statement(t, (equal(rest), above(sign)), (above(i), above(j)))


TARGET_NAMES = (*regions.TARGETS, *regions.TARGET_EDGES)
SIDE_NAMES = (*regions.SIDES, *regions.SIDE_EDGES)
WHY = "Nothing was left out when the claims were shown region by region."

CLAIMS = (
    Claim(
        "cover.targets",
        (18,),
        OURS,
        "the 11 regions and boundaries of v_c0 are all of the real line",
        WHY,
        "0 < v_u2 < v_u1",
        _cover(TARGET_NAMES, 1),
        Z3(),
    ),
    Claim(
        "cover.sides",
        (15,),
        OURS,
        "the 7 regions and boundaries of v are all of |v| < v_u1",
        WHY,
        "0 < v_u2 < v_u1",
        _cover(SIDE_NAMES, 0),
        Z3(),
    ),
    Claim(
        "cover.charts",
        (15, 18),
        OURS,
        "each chart of a bounded region runs through all of it",
        WHY,
        "v_u2 > 0, b = v_u1 - v_u2 > 0, 0 < y < 1, n = y/(1 - y)",
        _charted,
        Z3(),
    ),
    Claim(
        "cover.numbers",
        (15, 18),
        OURS,
        "n/(1 + n) takes every value between 0 and 1 at a positive n",
        WHY,
        "",
        _reached,
        Z3(),
    ),
    Claim(
        "cover.far",
        (18,),
        OURS,
        "beyond v_u2 + 1/b every v_c0 is u1 - d + 1/d at a gap d between 0 and b",
        WHY,
        "0 < v_u2 < v_u1, v_c0 > v_u2 + 1/(v_u1 - v_u2); mirrored for v_c0 < 0",
        _far_reached,
        Z3(),
    ),
    Claim(
        "cover.smooth-targets",
        (),
        OURS,
        "the 7 regions and boundaries of v_c0 for the smooth barrier are all of the real line",
        WHY,
        "0 < v_u2 < v_u1",
        _cover(regions.SMOOTH_TARGETS, 1),
        Z3(),
    ),
    Claim(
        "cover.beyond",
        (),
        OURS,
        "smooth barrier: beyond v_u2 every v_c0 is u1 - d + 1/d - 1/b at a gap d between 0 and b",
        WHY,
        "0 < v_u2 < v_u1 = v_u2 + b, v_u2 < v_c0 < 1e100; mirrored for v_c0 < 0",
        _beyond_reached,
        Z3(),
    ),
    Claim(
        "cover.order",
        (15, 18),
        OURS,
        "where |v| and |v_c1| share an interval, one of the three orders holds and is charted",
        WHY,
        "i, j > 0",
        _ordered,
        Z3(),
    ),
)
