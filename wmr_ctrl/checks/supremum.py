"""The longest stable control period: tried upwards from a short one, then bisected."""

from __future__ import annotations

import math
from collections.abc import Callable

SHORTEST, LONGEST, RATIO = 1e-4, 10.0, 1.15
"""Periods that are tried [s], and the factor from one to the next."""

MARGIN = 1e-9
"""A spectral radius this close to 1 is marginal: so is e2 while the reference stands still."""
RTOL = 1e-7
"""Of an edge of stability; four digits of it are printed."""


def supremum(
    of: Callable[[float], float],
    shortest: float = SHORTEST,
    ratio: float = RATIO,
    rtol: float = RTOL,
) -> float:
    """Largest period up to which the spectral radius ``of(period)`` stays at or below 1."""
    below, period = 0.0, shortest
    while of(period) <= 1 + MARGIN:
        if period >= LONGEST:
            return math.inf
        below, period = period, period * ratio
    return bisect(lambda t: of(t) <= 1 + MARGIN, below, period, rtol) if below else 0.0


def bisect(
    holds: Callable[[float], bool], inside: float, outside: float, rtol: float = 1e-9
) -> float:
    """The last x on the way from ``inside`` to ``outside`` with ``holds(x)``.

    True at ``inside``, which may be the larger of the two, and false at ``outside``.
    """
    while abs(outside - inside) > rtol * max(abs(inside), abs(outside)):
        middle = (inside + outside) / 2
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return inside
