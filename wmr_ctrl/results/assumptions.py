"""Whether a run's log contradicts the bounds that a guard assumes, be it on or off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results.monitor import Event

ROUNDING = 1e-6
"""Share of the largest force that may be an error of integration and rounding."""


def admitted(dbar: tuple[float, float], largest: tuple[float, float]) -> tuple[float, float]:
    """Largest d_least that does not contradict ``dbar``; arguments as in `first_beyond`."""
    return dbar[0] + ROUNDING * largest[0], dbar[1] + ROUNDING * largest[1]


def first_beyond(
    columns: Mapping[str, NDArray[np.float64]],
    dbar: tuple[float, float],
    largest: tuple[float, float],
) -> Event | None:
    """Time [s] and axis of the first row whose d_least is above ``dbar`` [N, N m], or None.

    ``largest`` is the force that stops the robot in one sample [N, N m]: the scale of d_least.
    """
    if "d_least" not in columns:
        return None
    rows, axes = np.nonzero(columns["d_least"] > np.array(admitted(dbar, largest)))
    return (float(columns["t"][rows[0]]), int(axes[0]) + 1) if rows.size else None


def largest_push(columns: Mapping[str, NDArray[np.float64]]) -> tuple[float, float] | None:
    """Largest d_least of a log [N, N m]; None where no row has one, as with a foreign controller.

    Rows that are not a number are passed over.
    """
    found = columns.get("d_least", np.empty((0, 2)))
    if np.isnan(found).all(axis=0).any():
        return None
    force, moment = np.fmax.reduce(found, axis=0).tolist()
    return force, moment
