"""Intervals of many numbers at once, rounded outward: what a computed bound may be trusted with.

Sums, products, quotients and roots are moved outward by one unit in the last place, elementary
functions by `LIBM` of their size, more than the error that NumPy states of its own (4 units).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
LIBM = 2.0**-49


@dataclass(frozen=True)
class Span:
    """Closed intervals [lo, hi], element by element."""

    lo: Floats
    hi: Floats

    @classmethod
    def of(cls, low: object, high: object | None = None) -> Span:
        """Intervals between doubles, each a point where ``high`` is left out."""
        lo = np.asarray(low, dtype=float)
        return cls(lo, lo if high is None else np.asarray(high, dtype=float))

    def __getitem__(self, place: Any) -> Span:
        """Some of the intervals, as NumPy picks them."""
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
        given = _span(other)
        corners = [a * b for a in (self.lo, self.hi) for b in (given.lo, given.hi)]
        return _outward(np.minimum.reduce(corners), np.maximum.reduce(corners))

    def __truediv__(self, other: Span | float) -> Span:
        """Enclosure of the quotient by what is positive; ValueError for other divisors."""
        given = _span(other)
        if not np.all(given.lo > 0):
            raise ValueError("a divisor is not certainly positive")
        corners = [a / b for a in (self.lo, self.hi) for b in (given.lo, given.hi)]
        return _outward(np.minimum.reduce(corners), np.maximum.reduce(corners))

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
    """Enclosure of the root of what is not negative; below 0 is taken for 0."""
    return _floored(_outward(np.sqrt(np.maximum(x.lo, 0.0)), np.sqrt(np.maximum(x.hi, 0.0))))


def increasing(function: Callable[[Floats], Floats], x: Span) -> Span:
    """Enclosure of an increasing elementary function of NumPy's."""
    return _loose(function(x.lo), function(x.hi))


def exp(x: Span) -> Span:
    """Enclosure of the exponential."""
    return _floored(increasing(np.exp, x))


def cosine(x: Span) -> Span:
    """Enclosure of cos(sqrt x), which is cosh(sqrt -x) below 0."""
    steep = 0.5 / np.sqrt(np.maximum(x.lo, 1.0))
    return _rolling(x, lambda y: np.where(y < 0, np.cosh(_root(-y)), np.cos(_root(y))), steep, -1.0)


def sine_over(x: Span) -> Span:
    """Enclosure of sin(sqrt x)/sqrt x, which is sinh(sqrt -x)/sqrt -x below 0."""
    steep = np.minimum(1 / np.maximum(x.lo, 1.0), 0.17)
    return _rolling(x, _sine_over, steep, -0.25)


def _sine_over(y: Floats) -> Floats:
    near = np.abs(y) < 1e-3
    w = np.where(near, 1.0, np.sqrt(np.abs(y)))
    far = np.where(y < 0, np.sinh(w), np.sin(w)) / w
    return np.where(near, 1 - y / 6 * (1 - y / 20 * (1 - y / 42)), far)


def _root(y: Floats) -> Floats:
    return np.sqrt(np.maximum(y, 0.0))


def _rolling(x: Span, function: Callable[[Floats], Floats], steep: Floats, least: float) -> Span:
    """Range of a function that falls up to pi^2, and is no steeper than ``steep`` from 0 on.

    The computed values are off by at most 1e-12 of their size, and of 1: arguments up to 1e3 are
    rounded a few times before.
    """
    left, right, middle = function(x.lo), function(x.hi), function(0.5 * (x.lo + x.hi))
    away = steep * (0.5 * (x.hi - x.lo)) * (1 + 1e-12)
    falls, swings = x.hi <= 9.8, x.lo >= 0
    low = np.where(falls, right, np.where(swings, np.maximum(middle - away, least), least))
    high = np.where(falls, left, np.where(swings, middle + away, np.maximum(left, 1.0)))
    return Span(low - 1e-12 * (1 + np.abs(low)), high + 1e-12 * (1 + np.abs(high)))


def _span(value: Span | Floats | float) -> Span:
    return value if isinstance(value, Span) else Span.of(value)


def _floored(x: Span) -> Span:
    return Span(np.maximum(x.lo, 0.0), x.hi)


def _outward(low: Floats, high: Floats) -> Span:
    return Span(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))


def _loose(low: Floats, high: Floats) -> Span:
    return _outward(low - LIBM * np.abs(low), high + LIBM * np.abs(high))
