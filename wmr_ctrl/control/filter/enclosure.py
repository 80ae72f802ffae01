"""Interval arithmetic on arrays, rounded outward, for bounds that must be rigorous.

Sums, products, quotients and roots are moved outward by one unit in the last place, elementary
functions by `LIBM` of their size, which exceeds NumPy's stated error (4 units).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ScenarioError

Floats: TypeAlias = NDArray[np.float64]
LIBM = 2.0**-49
STIFFEST = 600.0
"""Largest argument of a hyperbolic cosine: products with it are still numbers."""
FEW = 200
"""Numbers of which NumPy finds the next ones at once."""


@dataclass(frozen=True)
class Span:
    """Closed intervals [lo, hi], element by element."""

    lo: Floats
    hi: Floats

    @classmethod
    def of(cls, low: object, high: object | None = None) -> Span:
        """Intervals from doubles; point intervals if ``high`` is omitted."""
        lo = np.asarray(low, dtype=float)
        return cls(lo, lo if high is None else np.asarray(high, dtype=float))

    def __getitem__(self, place: Any) -> Span:
        """A selection of the intervals, by NumPy indexing."""
        return Span(self.lo[place], self.hi[place])

    def __add__(self, other: Span | float) -> Span:
        """Enclosure of the sum."""
        given = _span(other)
        return _outward(self.lo + given.lo, self.hi + given.hi)

    def __neg__(self) -> Span:
        """The negatives, exactly."""
        return Span(-self.hi, -self.lo)

    def __sub__(self, other: Span | float) -> Span:
        """Enclosure of the difference."""
        return self + -_span(other)

    def __mul__(self, other: Span | Floats | float) -> Span:
        """Enclosure of the product."""
        return _of_corners(np.multiply, self, _span(other))

    def __truediv__(self, other: Span | float) -> Span:
        """Enclosure of the quotient by positive intervals; ScenarioError for others."""
        given = _span(other)
        if not np.all(given.lo > 0):
            raise ScenarioError(
                "[filter]: its numbers, and robot.l, differ so much in size that a bound would be "
                "divided by 0. State numbers of a base that can be built."
            )
        return _of_corners(np.divide, self, given)

    def __radd__(self, other: float) -> Span:
        """Enclosure of the sum."""
        return self + other

    def __rmul__(self, other: float) -> Span:
        """Enclosure of the product."""
        return self * other

    def __rsub__(self, other: float) -> Span:
        """Enclosure of the difference."""
        return -self + other

    def __rtruediv__(self, other: float) -> Span:
        """Enclosure of the quotient."""
        return _span(other) / self

    @property
    def size(self) -> Floats:
        """Largest absolute value."""
        return np.maximum(-self.lo, self.hi)

    @property
    def magnitude(self) -> Span:
        """Absolute values."""
        return Span(np.maximum(np.maximum(self.lo, -self.hi), 0.0), self.size)


def square(x: Span) -> Span:
    """Enclosure of x^2, which is not negative."""
    return _floored(x.magnitude * x.magnitude)


def root(x: Span) -> Span:
    """Enclosure of the square root; negative values are treated as 0."""
    return _floored(_outward(np.sqrt(np.maximum(x.lo, 0.0)), np.sqrt(np.maximum(x.hi, 0.0))))


def increasing(function: Callable[[Floats], Floats], x: Span) -> Span:
    """Enclosure of one of NumPy's increasing elementary functions."""
    return _loose(function(x.lo), function(x.hi))


def exp(x: Span) -> Span:
    """Enclosure of the exponential."""
    return _floored(increasing(np.exp, x))


def cosine(x: Span) -> Span:
    """Enclosure of cos(sqrt x), which is cosh(sqrt -x) below 0.

    Raises ScenarioError, about the family of loops, if it would overflow.
    """
    if np.min(x.lo) < -(STIFFEST**2):
        raise ScenarioError(
            "filter: some loops of the stated family fade in two parts, one so much sooner than "
            "the other that no bounds of their step responses are known. Lower the upper end of kp "
            'or damping, raise the lower end of ki, or use filter.kind = "clip" without '
            "filter.slew."
        )
    steep = 0.5 / np.sqrt(np.maximum(x.lo, 1.0))
    return _rolling(x, lambda y: np.where(y < 0, np.cosh(_root(-y)), np.cos(_root(y))), steep, -1.0)


def sine_over(x: Span) -> Span:
    """Enclosure of sin(sqrt x)/sqrt x, which is sinh(sqrt -x)/sqrt -x below 0."""
    steep = np.minimum(1 / np.maximum(x.lo, 1.0), 0.17)
    return _rolling(x, _sine_over, steep, -0.25)


def _sine_over(y: Floats) -> Floats:
    near = np.abs(y) < 1e-3
    w = np.where(near, 1.0, np.sqrt(np.abs(y)))
    far = np.where(y < 0, np.sinh(np.where(y < 0, w, 0.0)), np.sin(w)) / w
    return np.where(near, 1 - y / 6 * (1 - y / 20 * (1 - y / 42)), far)


def _root(y: Floats) -> Floats:
    return np.sqrt(np.maximum(y, 0.0))


def _rolling(x: Span, function: Callable[[Floats], Floats], steep: Floats, least: float) -> Span:
    """Range of a function that falls up to pi^2, and has slope at most ``steep`` from 0 on.

    Computed values have errors of at most 1e-12 relative to max(1, size): arguments up to 1e3 are
    rounded a few times before.
    """
    left, right, middle = function(x.lo), function(x.hi), function(0.5 * (x.lo + x.hi))
    away = steep * (0.5 * (x.hi - x.lo)) * (1 + 1e-12)
    falls, swings = x.hi <= 9.8, x.lo >= 0
    low = np.where(falls, right, np.where(swings, np.maximum(middle - away, least), least))
    high = np.where(swings & ~falls, middle + away, left)
    return Span(low - 1e-12 * (1 + np.abs(low)), high + 1e-12 * (1 + np.abs(high)))


def _span(value: Span | Floats | float) -> Span:
    return value if isinstance(value, Span) else Span.of(value)


def _floored(x: Span) -> Span:
    return Span(np.maximum(x.lo, 0.0), x.hi)


def _of_corners(operation: np.ufunc, x: Span, y: Span) -> Span:
    """Enclosure of an operation that is monotone in both arguments, from its corners."""
    starts, ends = (
        (x.lo,) if x.lo is x.hi else (x.lo, x.hi),
        (y.lo,) if y.lo is y.hi else (y.lo, y.hi),
    )
    corners = [operation(a, b) for a in starts for b in ends]
    return _outward(reduce(np.minimum, corners), reduce(np.maximum, corners))


def _outward(low: Floats, high: Floats) -> Span:
    return Span(below(low), above(high))


def below(values: Floats) -> Floats:
    """The next doubles below."""
    return _next(values, -1)


def above(values: Floats) -> Floats:
    """The next doubles above."""
    return _next(values, 1)


def _next(values: Floats, way: int) -> Floats:
    """np.nextafter for many numbers, in a tenth of its time.

    The bits of doubles of one sign, read as integers, are in the order of the doubles.
    """
    end = math.copysign(math.inf, way)
    if values.size < FEW:
        return np.asarray(np.nextafter(values, end))
    bits = values.view(np.int64)
    step = bits >> 63
    step |= 1  # 1 from 0 on, -1 below
    moved = (np.add if way > 0 else np.subtract)(bits, step, out=step).view(np.float64)
    odd = ~(np.isfinite(values) & (values != 0))
    if odd.any():
        moved[odd] = np.nextafter(values[odd], end)
    return moved


def _loose(low: Floats, high: Floats) -> Span:
    return _outward(low - LIBM * np.abs(low), high + LIBM * np.abs(high))
