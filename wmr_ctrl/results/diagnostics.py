"""Further readings of a run: weights, rises of the barrier function, distance and settling."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.windows import covered, span

if TYPE_CHECKING:
    from wmr_ctrl.results.run import FloatArray, Run


@dataclass(frozen=True, slots=True)
class Rises:
    """Increases from one sample to the next: their number, their sum, the largest of them."""

    count: int
    total: float
    largest: float


@dataclass(frozen=True, slots=True)
class WeightNorm:
    """Norm of each axis' network weights at the last sample, and its largest over the run."""

    end: tuple[float, ...]
    largest: tuple[float, ...]


def rises(run: Run, start: float = 0.0, end: float | None = None) -> Rises | None:
    """Rises of the barrier function V1, Eq. (12), within [start, end) [s].

    Without ``end``, up to the last row; None where the run does not cover the window.
    """
    rows = span(run, start, end)
    if rows is None:
        return None
    steps = np.diff(run["V1"][rows])
    up = steps[steps > 0]
    return Rises(len(up), float(np.sum(up)), float(np.max(up, initial=0.0)))


def weight_norm(run: Run) -> WeightNorm | None:
    """Norms of the weights [1] per axis, or None for a law without weights or an empty run."""
    if "W_norm" not in run or run.rows == 0:
        return None
    norms = run["W_norm"]
    return WeightNorm(tuple(norms[-1].tolist()), tuple(np.max(norms, axis=0).tolist()))


def distance(run: Run) -> FloatArray:
    """Distance of the robot from its reference point [m] at each sample, shape (N,)."""
    return np.hypot(run["x"] - run["x_d"], run["y"] - run["y_d"])


def settling_time(run: Run, within: float) -> float | None:
    """First sample time [s] from which the distance stays <= ``within`` [m] to the end.

    None for a run that ended early, or whose last sample is farther away.
    """
    if covered(run) < run.settings.samples:
        return None
    outside = np.flatnonzero(~(distance(run) <= within))
    first = int(outside[-1]) + 1 if outside.size else 0
    return float(run.time[first]) if first < run.rows else None
