"""The table behind the authority entries: its cells are chosen in doubles and checked exactly.

Each row and each link is checked exactly.  So are the facts that they join and reach both ends.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import log, sqrt
from operator import itemgetter

from wmr_proofs.methods.spec import Point

LARGEST_TARGET = 20.0
STEP = 0.008
"""Relative step of d_max from row to row."""
ROOM = 0.008
"""Relative distance of the upper bound above the maximum."""
CLIP = 1e-6
"""limits.clip of the paper's presets: barrier quantities see no velocity nearer to the limit."""

GOLDEN = (sqrt(5) - 1) / 2
SECTIONS, HALVINGS = 40, 35
"""Steps of a search: a place to 4e-9 of its range is more than a table in steps of STEP needs."""


@dataclass(frozen=True)
class Row:
    """Velocity of the maximum of rho V1/A at v_c0 = c, with a lower and an upper bound of it."""

    c: float
    v: float
    low: float
    high: float


@dataclass(frozen=True)
class Numbers:
    """The function in plain doubles, only to choose the cells; the checks are exact."""

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

    def value(self, c: float) -> Callable[[float], float]:
        """V1i at v."""
        x, f = self.target(c), self.f
        plain, barrier = 0.5 * (x - c) ** 2, f(x)
        return lambda v: 0.5 * (v - c) ** 2 + f(v) - plain - barrier

    def slope(self, v: float, c: float) -> float:
        """A_i."""
        return v - c + (1 / (self.u1 - v) if v > self.u2 else 0.0)

    def resisted(self, c: float) -> Callable[[float], float]:
        """rho V1/A at v."""
        value, slope, rho = self.value(c), self.slope, self.rho
        return lambda v: rho * value(v) / slope(v, c)

    def best(self, c: float) -> tuple[float, float]:
        """Velocity at which rho V1/A is largest, and its value there.

        It is v_u2, where the plain range ends, or lies beyond it.
        """
        target, resisted = self.target(c), self.resisted(c)
        ahead = _top(resisted, max(target, self.u2) + 1e-9, self.u1 - 1e-9)
        plain = self.u2 if target < self.u2 else ahead
        return max(((plain, resisted(plain)), (ahead, resisted(ahead))), key=itemgetter(1))

    def rows(self) -> list[Row]:
        """Rows from c = 0 to the largest target, in steps that lower the maximum by STEP."""
        c, found = 0.0, []
        while True:
            v, top = self.best(c)
            found.append(Row(c, v, top * (1 - 1e-4), top * (1 + ROOM)))
            if c >= LARGEST_TARGET:
                return found
            c = min(LARGEST_TARGET, self._next(c, top * (1 - STEP)))

    def _next(self, c: float, wanted: float) -> float:
        return _last(c, c + 4.0, lambda place: self.best(place)[1] > wanted)

    def steps(self, row: Row) -> Iterator[tuple[float, float]]:
        """Pairs a < b with rho V1(b)/A(a) <= high, from v_c1 + high/rho to the clip."""
        end = self.u1 - CLIP
        a = (self.target(row.c) + row.high / self.rho) * (1 - 1e-12)  # not beyond, in doubles
        while a < end:
            b = self._reach(a, row, end)
            yield a, b
            a = b

    def _reach(self, a: float, row: Row, end: float) -> float:
        wanted = row.high * (1 - 1e-9) / self.rho * self.slope(a, row.c)
        value = self.value(row.c)
        return end if value(end) <= wanted else _last(a, end, lambda v: value(v) <= wanted)


def _last(low: float, high: float, holds: Callable[[float], bool]) -> float:
    """Last place at which it holds, by halving: it does at ``low``, and not at ``high``."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def _top(function: Callable[[float], float], low: float, high: float) -> float:
    """Maximiser of a unimodal function, by golden-section search."""
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    left, right = function(a), function(b)
    for _ in range(SECTIONS):
        if left < right:
            low, a, left = a, b, right
            b = low + GOLDEN * (high - low)
            right = function(b)
        else:
            high, b, right = b, a, left
            a = high - GOLDEN * (high - low)
            left = function(a)
    return 0.5 * (low + high)


@lru_cache(maxsize=2)
def rows(axis: int) -> tuple[Row, ...]:
    """The table of one axis; chosen in doubles, so it does not depend on any graph."""
    return tuple(AXES[axis].rows())


@lru_cache(maxsize=2)
def links(axis: int) -> tuple[tuple[tuple[float, float], ...], ...]:
    """Chain of intervals of each row of the table."""
    return tuple(tuple(AXES[axis].steps(row)) for row in rows(axis))


AXES = (Numbers(1.0, 0.8, 15.0), Numbers(1.5, 1.3, 57.6))


def low_points(axis: int) -> list[Point]:
    """One point per row."""
    n = AXES[axis]
    return [{"v": r.v, "c": r.c, **vars(n), "low": r.low} for r in rows(axis)]


def high_points(axis: int) -> list[Point]:
    """The chain of intervals of every row."""
    n = AXES[axis]
    return [
        {"v": a, "b": b, "c": r.c, **vars(n), "high": r.high}
        for r, chain in zip(rows(axis), links(axis), strict=True)
        for a, b in chain
    ]


def ratio_points(axis: int) -> list[Point]:
    """Neighbouring rows."""
    return [{"high": a.high, "low": b.low} for a, b in pairwise(rows(axis))]


def link_points(axis: int) -> list[Point]:
    """Links of every row, each with the end of the one before; ``first`` and ``last`` are 1."""
    n, points = AXES[axis], list[Point]()
    for r, chain in zip(rows(axis), links(axis), strict=True):
        for k, (a, b) in enumerate(chain):
            place = {"first": float(k == 0), "last": float(k == len(chain) - 1)}
            own = {"v": a, "b": b, "before": chain[k - 1][1] if k else 0.0, **place}
            points.append({**own, "c": r.c, **vars(n), "high": r.high})
    return points


def row_points(axis: int) -> list[Point]:
    """Every row's v_c0 with the one before; ``first`` and ``last`` are 1 at the ends."""
    table = [row.c for row in rows(axis)]
    last = len(table) - 1
    return [
        {"c": c, "before": table[max(k - 1, 0)], "first": float(k == 0), "last": float(k == last)}
        for k, c in enumerate(table)
    ]
