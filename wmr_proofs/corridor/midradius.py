"""Spans: many intervals, each a midpoint and a radius in doubles, rounded outwards."""

from __future__ import annotations

from collections.abc import Callable
from types import EllipsisType
from typing import TypeAlias

import numpy as np
from flint import arb

from wmr_ctrl.theory.checks.error_coordinates import Floats

from .enclosure import OpenBoxError

ROUNDED = 2.0**-52
"""Twice the relative rounding error of a result."""
OUTWARD = 1 + 2.0**-48
"""Factor that covers a radius's own rounding."""
SMALLEST = 1e-300
"""Size that is added to a radius against underflow."""


def rounding(count: int) -> float:
    """Relative rounding error of a sum of ``count`` products, in any order of summation."""
    return (count + 2) * ROUNDED


Places: TypeAlias = "tuple[slice | int | EllipsisType | None, ...]"


class MidRadius:
    """Numbers within ``radius`` of ``middle``, element by element."""

    __slots__ = ("middle", "radius")

    def __init__(self, middle: Floats | float, radius: Floats | float = 0.0) -> None:
        self.middle, self.radius = np.asarray(middle), np.asarray(radius)

    @property
    def ends(self) -> tuple[Floats, Floats]:
        """Doubles below and above all numbers within."""
        wide = self.radius * OUTWARD + ROUNDED * np.abs(self.middle) + SMALLEST
        return self.middle - wide, self.middle + wide

    @property
    def most(self) -> Floats:
        """Upper bounds of the absolute values of all numbers within."""
        return np.asarray((np.abs(self.middle) + self.radius) * OUTWARD + SMALLEST)

    def __add__(self, other: MidRadius) -> MidRadius:
        middle = self.middle + other.middle
        return _rounded(middle, self.radius + other.radius)

    def __neg__(self) -> MidRadius:
        return MidRadius(-self.middle, self.radius)

    def __sub__(self, other: MidRadius) -> MidRadius:
        return self + -other

    def __mul__(self, other: MidRadius) -> MidRadius:
        wide = np.abs(self.middle) * other.radius + self.radius * other.most
        return _rounded(self.middle * other.middle, wide)

    def __truediv__(self, other: MidRadius) -> MidRadius:
        size = np.abs(other.middle)
        least = (size - other.radius) / OUTWARD
        if not (least > 0).all():
            raise OpenBoxError("a quotient by what may be 0")
        middle = self.middle / other.middle
        return _rounded(middle, (self.radius + np.abs(middle) * other.radius) / least)

    def __matmul__(self, other: MidRadius) -> MidRadius:
        """Products of stacked matrices."""
        sizes, share = np.abs(self.middle), rounding(self.middle.shape[-1])
        wide = sizes @ (other.radius + share * np.abs(other.middle))
        wide = wide + self.radius @ other.most
        return MidRadius(self.middle @ other.middle, wide * (1 + share) * OUTWARD + SMALLEST)

    def __getitem__(self, places: Places) -> MidRadius:
        radius = self.radius
        if radius.shape != self.middle.shape:
            radius = np.broadcast_to(radius, self.middle.shape)
        return MidRadius(self.middle[places], radius[places])

    def __abs__(self) -> MidRadius:
        return MidRadius(np.abs(self.middle), self.radius)

    def by_balls(self, operation: Callable[[arb], arb]) -> MidRadius:
        """An operation on balls, element by element."""
        middle, radius = np.broadcast_arrays(self.middle, self.radius)
        pairs = zip(middle.ravel().tolist(), radius.ravel().tolist(), strict=True)
        result = [operation(arb(*pair)) for pair in pairs]
        if not all(item.is_finite() for item in result):
            raise OpenBoxError("an operation leaves its domain")
        new, wide = ([float(part(x)) for x in result] for part in (arb.mid, arb.rad))
        shape = middle.shape
        return _rounded(np.array(new).reshape(shape), np.array(wide).reshape(shape))


def _rounded(middle: Floats, radius: Floats) -> MidRadius:
    return MidRadius(middle, (radius + ROUNDED * np.abs(middle)) * OUTWARD + SMALLEST)


def widened(a: MidRadius, more: Floats | float) -> MidRadius:
    """The span with ``more`` added to its radius."""
    return MidRadius(a.middle, (a.radius + more) * OUTWARD)


def hull(points: Floats, axis: int) -> MidRadius:
    """Spans that contain all points along an axis.

    The share of ``high - low`` covers the rounding of a ``high`` that is larger than ``low``.
    """
    low, high = points.min(axis=axis), points.max(axis=axis)
    wide = (high - low) / 2 * (1 + 2**-40) + ROUNDED * np.abs(low)
    return MidRadius((low + high) / 2, np.where(low == high, 0.0, wide))
