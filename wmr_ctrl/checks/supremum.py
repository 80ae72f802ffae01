"""The longest stable control period: tried upwards from a short one, then bisected."""

from __future__ import annotations

import math
from collections.abc import Callable

SHORTEST, LONGEST, RATIO = 1e-4, 10.0, 1.15
"""Periods that are tried [s], and the factor from one to the next."""

MARGIN = 1e-9
"""A spectral radius this close to 1 is marginal: so is e2 while the reference stands still."""


def supremum(
    of: Callable[[float], float],
    shortest: float = SHORTEST,
    ratio: float = RATIO,
    rtol: float = 1e-7,
) -> float:
    """Largest period up to which the spectral radius ``of(period)`` stays at or below 1."""
    below, period = 0.0, shortest
    while of(period) <= 1 + MARGIN:
        if period >= LONGEST:
            return math.inf
        below, period = period, period * ratio
    return bisect(lambda t: of(t) <= 1 + MARGIN, below, period, rtol) if below else 0.0


def bisect(holds: Callable[[float], bool], below: float, above: float, rtol: float = 1e-9) -> float:
    """Largest x in [below, above] with ``holds(x)``: true at ``below``, false at ``above``."""
    while above - below > rtol * abs(above):
        middle = (below + above) / 2
        below, above = (middle, above) if holds(middle) else (below, middle)
    return below
