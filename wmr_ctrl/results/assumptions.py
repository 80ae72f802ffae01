"""Whether a guarded run's log contradicts the bounds that its guard assumes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results.monitor import Event

ROUNDING = 1e-6
"""Share of the largest force that may be an error of integration and rounding."""


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
    bound = np.array(dbar) + ROUNDING * np.array(largest)
    rows, axes = np.nonzero(columns["d_least"] > bound)
    return (float(columns["t"][rows[0]]), int(axes[0]) + 1) if rows.size else None
