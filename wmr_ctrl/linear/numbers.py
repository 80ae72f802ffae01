"""Small numerical helpers of the linear analysis."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def column(value: Any) -> Floats:
    """A CasADi column as a flat array."""
    return np.asarray(value, dtype=float).ravel()


def bisect(holds: Callable[[float], bool], below: float, above: float, rtol: float = 1e-9) -> float:
    """Largest x in [below, above] with ``holds(x)``: true at ``below``, false at ``above``."""
    while above - below > rtol * abs(above):
        middle = (below + above) / 2
        below, above = (middle, above) if holds(middle) else (below, middle)
    return below


MARGINAL = 1e-7
"""Real parts up to this [1/s] count as zero: an estimate without leak, a reference that stands."""


def is_stable(poles: Any, sampled: bool = False) -> bool:
    """Whether no pole is outside the stable region; marginal ones count as stable."""
    found = np.asarray(poles, dtype=complex)
    return bool(
        (np.abs(found) <= 1 + MARGINAL).all() if sampled else (found.real <= MARGINAL).all()
    )


def radius(matrix: Floats) -> float:
    """Spectral radius."""
    return float(np.abs(np.linalg.eigvals(matrix)).max()) if matrix.size else 0.0
