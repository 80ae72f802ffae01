"""Bounds of the step responses of a whole family of linear loops, rounded outward.

A loop that reaches its command at rest has the step response S = 1 - e, and e the transform

    E(s) = (s + gamma)/(s^2 + a s + b)        PI loop: a = (kp + c)/M, b = ki/M, gamma = c/M
                                        second order: a = gamma = 2 z w0, b = w0^2
    e(t) = exp(-a t/2) (cos(w t) + (gamma - a/2) sin(w t)/w),    w^2 = b - a^2/4 of any sign

The family is covered by cells of (a, b), or of (w0, z), on each of which e and e' are enclosed at
the ends of pieces of time. Within a piece, e'' bounds the distance of e from the values at its
ends: e'' = -a e' - b e, and e'^2 + b e^2 never grows. Behind the last piece exp(lambda t) e is held
by a like sum.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.world.scenario import Scenario

from .enclosure import (
    Floats,
    Span,
    above,
    below,
    cosine,
    exp,
    root,
    sine_over,
    square,
)
from .governor import NEAR
from .peak_gain import PiLoop, pi_loop

GRID = 64
"""Cells along each side of the family."""
CHUNK = 128
SWINGS = 3.2
"""Length of the tables, over the slowest time constant: what is left behind is some per cent."""
SWING_PIECES = 400


@dataclass(frozen=True)
class Cells:
    """Parts of a family: intervals of a, b and gamma; ``w2`` is b - a^2/4."""

    a: Span
    b: Span
    gamma: Span
    w2: Span

    def __getitem__(self, part: slice) -> Cells:
        """Selection of the cells, as a column."""
        return Cells(*(item[part, None] for item in self._every))

    @property
    def _every(self) -> tuple[Span, ...]:
        return self.a, self.b, self.gamma, self.w2

    def beside(self, other: Cells) -> Cells:
        """These cells together with further ones."""
        pairs = zip(self._every, other._every, strict=True)
        ends = (((x.lo, y.lo), (x.hi, y.hi)) for x, y in pairs)
        return Cells(*(Span(np.hstack(low), np.hstack(high)) for low, high in ends))


@dataclass(frozen=True)
class Band:
    """low <= S <= high on each piece of time; |S - 1| <= left exp(-rate (t - end)) after the last.

    Everywhere |S - 1| <= reach exp(-rate t).  On pieces and after them t may be late by twice the
    jitter, and by differences that count as 0.
    """

    low: Floats
    high: Floats
    left: float
    rate: float
    reach: float


def pi_cells(loop: PiLoop) -> Cells:
    """Cells of (a, b) that cover all loops of the family, with all gamma in each."""
    M, kp, ki, c = (Span.of(*pair) for pair in (loop.M, loop.kp, loop.ki, loop.c))
    held = kp + c
    a, b = _grid(_quotient(held, M), _quotient(ki, M))
    # Those whose mass is in its interval: M = (kp + c)/a = ki/b.
    by_a, by_b = _quotient(held, a), _quotient(ki, b)
    light = np.maximum(np.maximum(by_a.lo, by_b.lo), M.lo)
    heavy = np.minimum(np.minimum(by_a.hi, by_b.hi), M.hi)
    some = light <= heavy
    a, b = (Span(item.lo[some], item.hi[some]) for item in (a, b))
    light, heavy = light[some], heavy[some]
    # gamma = c/M = a - kp/M.  As M grows the one falls and the other rises: their least is largest
    # where they meet, and never above the larger of both beside it.
    meet = [(c.hi + kp.lo) / a.hi, (c.lo + kp.hi) / a.lo]
    least, most = (_beside(x, light, heavy) for x in reversed(meet))
    high = np.minimum((Span.of(c.hi) / most).hi, (Span.of(a.hi) - Span.of(kp.lo) / most).hi)
    low = np.maximum((Span.of(c.lo) / least).lo, (Span.of(a.lo) - Span.of(kp.hi) / least).lo)
    gamma = Span(np.maximum(low, 0.0), np.maximum(high, 0.0))
    family = Cells(a, b, gamma, b - 0.25 * square(a))
    own = loop.held.through() if loop.held else None
    return family.beside(Cells(own.a, own.b, own.gamma, own.w2)) if own else family


def _beside(place: Floats, low: Floats, high: Floats) -> Span:
    """A point, moved into its bounds, as an interval wider than its rounding error."""
    inside = np.clip(place, low, high)
    return Span(inside * (1 - 2.0**-50), inside * (1 + 2.0**-50))


def _quotient(x: Span, y: Span) -> Span:
    """Range of x/y, both positive and independent."""
    return Span((Span.of(x.lo) / Span.of(y.hi)).lo, (Span.of(x.hi) / Span.of(y.lo)).hi)


def second_order_cells(frequency: tuple[float, float], damping: tuple[float, float]) -> Cells:
    """Cells of (w0, z)."""
    w0, z = _grid(Span.of(*frequency), Span.of(*damping))
    a, b = 2 * z * w0, square(w0)
    return Cells(a, b, a, b * (1 - square(z)))


def _grid(first: Span, second: Span) -> tuple[Span, Span]:
    """Cells of two numbers."""
    x, y = (np.linspace(item.lo, item.hi, GRID + 1) for item in (first, second))
    i, j = (item.ravel() for item in np.meshgrid(range(GRID), range(GRID)))
    return Span(x[i], x[i + 1]), Span(y[j], y[j + 1])


def deviation(cells: Cells, t: Span) -> tuple[Span, Span]:
    """e and e' at times t (a row)."""
    x = cells.w2 * square(t)
    faded, turning, swinging = exp(-0.5 * cells.a * t), cosine(x), t * sine_over(x)
    e = faded * (turning + (cells.gamma - 0.5 * cells.a) * swinging)
    rate = faded * (turning - 0.5 * cells.a * swinging)  # of the impulse response, faded swinging
    return e, -((cells.a - cells.gamma) * rate) - cells.b * (faded * swinging)


def band(cells: Cells, T: float, pieces: int, most: int, jitter: float = 0.0) -> Band:
    """Bounds of the family's step responses; ``pieces`` a period, ``most`` periods at most."""
    rate, grid = _slowest(cells), _times(cells, T, pieces, most, jitter)
    low, high = np.full(len(grid.times) - 1, np.inf), np.full(len(grid.times) - 1, -np.inf)
    left, reach = 0.0, 0.0
    for part, e, speed in _responses(cells, grid.times):
        away = _bent(part, e, speed, T / pieces) + _strayed(part, e, speed, grid.near)
        lower, upper = _between(e, away.hi)
        low = np.minimum(low, _down(1 - np.max(upper, axis=0)))
        high = np.maximum(high, _up(1 - np.min(lower, axis=0)))
        left = max(left, float(_left(part, e, speed, rate, grid.last).max()))
        reach = max(reach, float(_left(part, e, speed, rate, 0).max()))
    low, high = grid.joined(low, np.minimum), grid.joined(high, np.maximum)
    return Band(np.maximum(low, 0.0), high, left * (1 + 2 * rate * grid.near), rate, reach)


@dataclass(frozen=True)
class _Grid:
    """Times at which pieces begin and end, also twice a jitter later; index of the last.

    Pieces may also be late by ``near``, a time that counts as 0.
    """

    times: Floats
    last: int
    parts: int
    near: float

    def joined(self, values: Floats, worse: np.ufunc) -> Floats:
        """Worst value over each piece's parts, and over those up to twice a jitter before it."""
        if self.parts == 1:
            return values
        before = np.concatenate([values[:1], values[1:-1:2]])  # from t - 2 jitter to t
        return np.asarray(worse.reduce([before, values[::2], values[1::2]]))


def _times(cells: Cells, T: float, pieces: int, most: int, jitter: float) -> _Grid:
    periods = int(np.clip(np.ceil(SWINGS / (_slowest(cells) * T)), 4, most))
    begins: Floats = np.asarray(np.arange(periods * pieces + 1) * (T / pieces))
    near = NEAR * T * (1 + 2.0**-10)  # and what roundings add to times
    if jitter == 0:
        return _Grid(begins, len(begins) - 1, 1, near)
    early = np.stack([begins[:-1], begins[1:] - 2 * jitter], axis=1).ravel()
    return _Grid(np.concatenate([early, begins[-1:]]), len(early) - 1, 2, near)


def _responses(cells: Cells, times: Floats) -> Iterator[tuple[Cells, Span, Span]]:
    """Chunks of cells, with e and e' of each at all times."""
    for start in range(0, len(cells.a.lo), CHUNK):
        part = cells[start : start + CHUNK]
        e, speed = deviation(part, Span(_down(times)[None], _up(times)[None]))
        yield part, e, speed


def _between(x: Span, bent: Floats) -> tuple[Floats, Floats]:
    """Bounds of a response x on each piece, from its end values and its curvature (`_bent`)."""
    upper = _up(np.maximum(x.hi[:, :-1], x.hi[:, 1:]) + bent)
    lower = _down(np.minimum(x.lo[:, :-1], x.lo[:, 1:]) - bent)
    return lower, upper


def _bent(cells: Cells, x: Span, slope: Span, length: float) -> Span:
    """Largest distance of a response from the chord of each piece.

    Its energy never grows, so the energy at a piece's start bounds this distance.
    """
    energy = square(slope[..., :-1]) + cells.b * square(x[..., :-1])
    return (cells.a + root(cells.b)) * root(energy) * (length**2 * (1 + 1e-12) / 8)


def _strayed(cells: Cells, x: Span, slope: Span, time: float) -> Span:
    """Largest change of a response on each piece if it is late by a small ``time``.

    Its slope is at most the root of its energy.  At the earlier time the energy was at most twice
    as large.
    """
    energy = square(slope[..., :-1]) + cells.b * square(x[..., :-1])
    return root(energy) * (2 * time)


def swing(cells: Cells) -> float:
    """Largest integral of |1 - S| [s] over the family, from the time when S first reaches 1.

    Before that, e = 1 - S decreases.  Within a piece |e| exceeds the chord by e's curvature at
    most.  Initial pieces on which e is surely positive do not count; after the last piece e decays.
    """
    rate = _slowest(cells)
    times = np.linspace(0.0, 2 * SWINGS / rate, SWING_PIECES + 1)
    longest = float(_up(np.diff(times).max()))
    most = 0.0
    for part, e, speed in _responses(cells, times):
        size, bent = e.magnitude, _bent(part, e, speed, longest)
        mean = 0.5 * (size[..., :-1] + size[..., 1:]) + bent
        rises = np.logical_and.accumulate(_between(e, bent.hi)[0] > 0, axis=1)
        behind = Span.of(_left(part, e, speed, rate, -1)) / rate
        total = np.sum(np.where(rises, 0.0, mean.hi), axis=1, keepdims=True)
        total = total * (1 + SWING_PIECES * 2.0**-52)
        most = max(most, float((Span.of(total) * longest + behind).hi.max()))
    return most


def longest_swing(scenario: Scenario, axis: int) -> float:
    """`swing` of an axis' family, as stated in a scenario's filter."""
    settings = scenario.filter
    if settings.loop[axis] == "pi":
        return _pi_swing(pi_loop(scenario, axis))
    frequency, damping = (settings.intervals(key)[axis] for key in ("frequency", "damping"))
    return _second_order_swing(frequency, damping)


@lru_cache(maxsize=64)
def _pi_swing(loop: PiLoop) -> float:
    """`swing` of PI loops, plus h (N - 1) for a held base, whose sum may exceed the integral."""
    held = loop.held.step * (loop.peak(0.0).gain - 1) if loop.held else 0.0
    return (swing(pi_cells(loop)) + held) * (1 + 2.0**-50)


@lru_cache(maxsize=64)
def _second_order_swing(frequency: tuple[float, float], damping: tuple[float, float]) -> float:
    return swing(second_order_cells(frequency, damping))


def _slowest(cells: Cells) -> float:
    """A decay rate of every member's step response, with a margin of a tenth."""
    half = 0.5 * cells.a.lo
    under = np.sqrt(np.maximum(half**2 - cells.b.lo, 0.0))
    return 0.9 * float(np.min(half - under))


def _left(cells: Cells, e: Span, speed: Span, rate: float, at: int) -> Floats:
    """Largest |e| exp(rate (t - start)) of each cell after ``start``, the time with index at."""
    count = e.lo.shape[1]
    last = [item[:, at % count : at % count + 1] for item in (e, speed)]
    stiff = cells.b - rate * cells.a + rate * rate
    if not (np.all(stiff.lo > 0) and np.all(cells.a.lo > 2 * rate)):
        return np.full((len(cells.a.lo), 1), np.inf)
    moved = last[1] + rate * last[0]
    return root(square(last[0]) + square(moved) / stiff).hi


def _down(values: NDArray[np.floating]) -> Floats:
    return below(np.asarray(values, dtype=float))


def _up(values: NDArray[np.floating]) -> Floats:
    return above(np.asarray(values, dtype=float))
