"""Ours: the constant disturbance that the paper's barrier withstands, d_max = rho max V1i/A_i."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, partial
from itertools import pairwise
from math import log, sqrt

import casadi as ca

from wmr_ctrl.barrier import paper as barrier
from wmr_ctrl.barrier.lyapunov import authority_limit
from wmr_ctrl.proofs.case import at
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.common import OFF_EDGES, BarrierAxis
from wmr_ctrl.proofs.methods.spec import Ball, Point, Ring, Table
from wmr_ctrl.proofs.regions import Axis, open_cases
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols

LARGEST_TARGET = 20.0
STEP, ROOM = 0.008, 0.008
"""Relative steps of d_max from row to row, and of the upper bound above the maximum."""


@dataclass(frozen=True)
class Row:
    """At v_c0 = c: the velocity of the maximum of rho V1/A, a bound below it and one above."""

    c: float
    v: float
    low: float
    high: float


@dataclass(frozen=True)
class Numbers:
    """The same function in plain doubles, only to choose where to look; the checks are exact."""

    u1: float
    u2: float
    rho: float

    def target(self, c: float) -> float:
        """v_c1 for c >= 0."""
        if c <= self.u2 + 1 / (self.u1 - self.u2):
            return min(c, self.u2)
        return (c + self.u1 - sqrt((c - self.u1) ** 2 + 4)) / 2

    def f(self, v: float) -> float:
        """f of Eq. (15)."""
        return -log((self.u1 - v) / (self.u1 - self.u2)) if v > self.u2 else 0.0

    def value(self, v: float, c: float) -> float:
        """V1i."""
        x = self.target(c)
        return 0.5 * (v - c) ** 2 + self.f(v) - 0.5 * (x - c) ** 2 - self.f(x)

    def slope(self, v: float, c: float) -> float:
        """A_i."""
        return v - c + (1 / (self.u1 - v) if v > self.u2 else 0.0)

    def resisted(self, v: float, c: float) -> float:
        """rho V1/A."""
        return self.rho * self.value(v, c) / self.slope(v, c)

    def best(self, c: float) -> float:
        """Velocity of the largest rho V1/A: the end of the plain range, or the top beyond v_u2."""
        low, high = max(self.target(c), self.u2) + 1e-9, self.u1 - 1e-9
        for _ in range(100):
            third = (high - low) / 3
            a, b = low + third, high - third
            low, high = (a, high) if self.resisted(a, c) < self.resisted(b, c) else (low, b)
        ahead = 0.5 * (low + high)
        plain = self.u2 if self.target(c) < self.u2 else ahead
        return plain if self.resisted(plain, c) >= self.resisted(ahead, c) else ahead

    def rows(self) -> list[Row]:
        """From c = 0 to the largest target, in steps that lower the maximum by STEP."""
        c, found = 0.0, []
        while True:
            v = self.best(c)
            top = self.resisted(v, c)
            found.append(Row(c, v, top * (1 - 1e-4), top * (1 + ROOM)))
            if c >= LARGEST_TARGET:
                return found
            c = min(LARGEST_TARGET, self._next(c, top * (1 - STEP)))

    def _next(self, c: float, wanted: float) -> float:
        low, high = c, c + 4.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (
                (middle, high)
                if self.resisted(self.best(middle), middle) > wanted
                else (low, middle)
            )
        return low

    def steps(self, row: Row) -> Iterator[tuple[float, float]]:
        """Pairs a < b with rho V1(b)/A(a) <= high, from v_c1 + high/rho to the clip."""
        end, a = self.u1 - 1e-6, self.target(row.c) + row.high / self.rho
        while a < end:
            b = self._reach(a, row, end)
            yield a, b
            a = b

    def _reach(self, a: float, row: Row, end: float) -> float:
        wanted = row.high * (1 - 1e-9) / self.rho * self.slope(a, row.c)
        low, high = a, end
        if self.value(end, row.c) <= wanted:
            return end
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.value(middle, row.c) <= wanted else (low, middle)
        return low


@lru_cache(maxsize=2)
def rows(axis: int) -> tuple[Row, ...]:
    """The table of one axis; chosen in doubles, so it does not depend on any graph."""
    return tuple(AXES[axis].rows())


AXES = (Numbers(1.0, 0.8, 15.0), Numbers(1.5, 1.3, 57.6))


def _exact(**values: float) -> Point:
    return {name: Fraction(value) for name, value in values.items()}


def low_points(axis: int) -> list[Point]:
    """One point per row."""
    n = AXES[axis]
    return [_exact(v=r.v, c=r.c, u1=n.u1, u2=n.u2, rho=n.rho, low=r.low) for r in rows(axis)]


def high_points(axis: int) -> list[Point]:
    """The chain of intervals of every row."""
    n = AXES[axis]
    return [
        _exact(v=a, b=b, c=r.c, u1=n.u1, u2=n.u2, rho=n.rho, high=r.high)
        for r in rows(axis)
        for a, b in n.steps(r)
    ]


def ratio_points(axis: int) -> list[Point]:
    """Neighbouring rows."""
    table = rows(axis)
    return [_exact(high=a.high, low=b.low) for a, b in pairwise(table)]


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


NONZERO = tuple(c for c in open_cases() if c.label != "v_c0 zero, v zero")
LIMIT_BOX = {"s": (Fraction("1e-300"), Fraction("0.99"))}
LIMIT_CUTS = {"s": [Fraction(f"1e-{k}") for k in (120, 40, 12, 6, 4, 3, 2, 1)]}
PAPER = "paper limits and gains, v_c0' = 0, |v| below the clip; mirrored for v_c0 < 0"


def _table(axis: int) -> tuple[Claim, ...]:
    name, unit = ("linear", "m/s^2") if axis == 0 else ("angular", "rad/s^2")
    return (
        Claim(
            f"authority.lower-{name}",
            (9,),
            OURS,
            f"on the {name} axis rho V1/A reaches the tabulated lower bounds of "
            "d_max, for v_c0 from 0 to 20",
            f"A disturbance up to the bound [{unit}] is held back before the limit.",
            PAPER,
            _low,
            Table(points=partial(low_points, axis)),
        ),
        Claim(
            f"authority.upper-{name}",
            (9,),
            OURS,
            f"on the {name} axis rho V1/A nowhere exceeds the tabulated upper "
            "bounds: on [a, b] it is at most rho V1(b)/A(a)",
            "A larger constant disturbance pushes the robot over its limit, whatever the law does.",
            PAPER + "; below v_c1 + bound/rho by P5",
            _high,
            Table(points=partial(high_points, axis)),
            uses=("authority.rises", "P5"),
        ),
        Claim(
            f"authority.98-{name}",
            (9,),
            OURS,
            f"on the {name} axis, between any two neighbouring rows, the lower bound "
            "is at least 98 % of the upper one",
            "The bound on the disturbance is known to two per cent for every |v_c0| <= 20.",
            "V1/A falls with v_c0, so rows bracket what is between",
            _ratio,
            Table(points=partial(ratio_points, axis)),
            uses=("authority.falls",),
        ),
    )


CLAIMS = (
    Claim(
        "authority.falls",
        (9,),
        OURS,
        "V1/A falls as v_c0 rises: its derivative times A^2 is V1 - A w <= -w^2/2",
        "The farther the robot is from where it should be, the weaker the barrier.",
        OFF_EDGES,
        _falls_with_target,
        Ring(NONZERO, log_lemma=True),
        uses=("P3", "lemma.log"),
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
        Ring(tuple(Axis().case("far+", "out+", order) for order in ("<", ">"))),
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
        uses=("authority.shape", "lemma.log"),
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
        uses=("authority.lower-linear", "authority.upper-linear", "lemma.comparison"),
    ),
)
