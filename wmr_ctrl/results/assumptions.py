"""Whether a run's log contradicts the bounds that a guard assumes, be it on or off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results.monitor import Event

Pair: TypeAlias = tuple[float, float]

ROUNDING = 1e-6
"""Share of the largest force that may be an error of integration and rounding."""


def stopping_force(mass: Pair, limit: Pair, period: float) -> Pair:
    """Force that stops the robot from the limit in one sample [N, N m]; symbols will do too."""
    return mass[0] * limit[0] / period, mass[1] * limit[1] / period


def admitted(dbar: Pair, largest: Pair) -> Pair:
    """Largest d_least that does not contradict ``dbar``; arguments as in `Assumptions`."""
    return dbar[0] + ROUNDING * largest[0], dbar[1] + ROUNDING * largest[1]


@dataclass(frozen=True)
class Assumptions:
    """What a guard assumes of the motion: largest disturbance and force per axis [N, N m].

    ``force`` stops the robot in one sample: the scale of what the monitor compares.  ``void``: what
    the scenario has that no such bound covers, in sentences.  ``usable`` and ``asked``, with the
    guard on: largest steady speeds that it leaves, and those of the reference [m/s, rad/s].
    ``M_min``, ``M_max`` [kg, kg m2], ``nbar`` [m/s, rad/s], ``alpha`` [1/s]: as in `Guard`.
    """

    dbar: tuple[float, float]
    force: tuple[float, float]
    void: str = ""
    usable: Pair | None = None
    asked: Pair | None = None
    M_min: Pair | None = None
    M_max: Pair | None = None
    nbar: Pair | None = None
    alpha: float | None = None


def first_beyond(columns: Mapping[str, NDArray[np.float64]], bounds: Assumptions) -> Event | None:
    """Time [s] and axis of the first row whose d_least contradicts ``bounds``, or None."""
    if "d_least" not in columns:
        return None
    rows, axes = np.nonzero(columns["d_least"] > np.array(admitted(bounds.dbar, bounds.force)))
    return (float(columns["t"][rows[0]]), int(axes[0]) + 1) if rows.size else None


def largest_push(columns: Mapping[str, NDArray[np.float64]]) -> tuple[float, float] | None:
    """Largest d_least of a log [N, N m]; None where no row has one, as with a foreign controller.

    Rows that are not a number are passed over.
    """
    least = columns.get("d_least", np.empty((0, 2)))
    if np.isnan(least).all(axis=0).any():
        return None
    force, moment = np.fmax.reduce(least, axis=0).tolist()
    return force, moment
