"""The spread of a figure over seeds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

STATISTICS = ("median", "min", "max", "q25", "q75", "mean", "std")
"""The statistics of a :class:`Spread`, in the order of the table's rows."""


@dataclass(frozen=True, slots=True)
class Spread:
    """``count`` numbers in short: median, extremes, quartiles, mean and standard deviation.

    ``std`` divides by ``count``.  All are None where there is no number.
    """

    count: int
    median: float | None = None
    min: float | None = None
    max: float | None = None
    q25: float | None = None
    q75: float | None = None
    mean: float | None = None
    std: float | None = None


def spread(values: Iterable[float | None]) -> Spread:
    """The spread of those values that are not None."""
    numbers = np.array([value for value in values if value is not None], dtype=np.float64)
    if not numbers.size:
        return Spread(0)
    low, q25, median, q75, high = np.quantile(numbers, (0, 0.25, 0.5, 0.75, 1)).tolist()
    mean, std = float(np.mean(numbers)), float(np.std(numbers))
    return Spread(numbers.size, median, low, high, q25, q75, mean, std)
