"""How well a run tracked and what that took: position, the guard's share, change of torques.

A figure of the last quarter or half is None for a run that did not last to its end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.diagnostics import distance
from wmr_ctrl.results.settings import Settings
from wmr_ctrl.results.windows import covered

if TYPE_CHECKING:
    from wmr_ctrl.results.run import FloatArray, Run

Pair = tuple[float, float]


def last_quarter(settings: Settings) -> tuple[int, int]:
    """Samples [first, end) of the last quarter of a whole run."""
    return 3 * settings.samples // 4, settings.samples


def last_half(settings: Settings) -> tuple[int, int]:
    """Samples [first, end) of the last half of a whole run, without the very first sample."""
    return max(settings.samples // 2, 1), settings.samples


def rows_of(run: Run, samples: tuple[int, int]) -> slice | None:
    """The rows of a window of samples; None where the run does not cover it or it is empty."""
    first, end = samples
    return slice(first, end) if first < end <= covered(run) else None


def position_rms(run: Run) -> dict[str, float | None]:
    """RMS distance from the desired position [m]: over ``all`` samples and the ``last_quarter``."""
    return {
        "all": _rms_distance(run, (0, run.settings.samples)),
        "last_quarter": _rms_distance(run, last_quarter(run.settings)),
    }


def position_max(run: Run) -> float | None:
    """Largest distance from the desired position over the last quarter [m]."""
    rows = rows_of(run, last_quarter(run.settings))
    return None if rows is None else float(np.max(distance(run)[rows]))


def tracked(run: Run) -> bool | None:
    """Whether the position's RMS over the last quarter is within metrics.tolerance.

    False for a run that ended early, None where the tolerance is not known.
    """
    if run.settings.tolerance is None:
        return None
    late = position_rms(run)["last_quarter"]
    return late is not None and late <= run.settings.tolerance


def arrival(run: Run) -> dict[str, float | None] | None:
    """When ``reference`` and ``robot`` are at the goal [s]; None where there is no goal.

    The robot's is the first sample from which it stays within metrics.tolerance of the goal to
    the run's end; None where it never does, or the run ends before the reference is there.
    """
    settings = run.settings
    if settings.arrival is None:
        return None
    there = None
    if settings.tolerance is not None and run.rows > settings.index(settings.arrival):
        away = np.hypot(run["x"] - run["x_d"][-1], run["y"] - run["y_d"][-1])
        late = np.flatnonzero(~(away <= settings.tolerance))
        first = late[-1] + 1 if late.size else 0
        there = float(run.time[first]) if first < run.rows and covered(run) == run.rows else None
    return {"reference": settings.arrival, "robot": there}


def guard_share(run: Run, samples: tuple[int, int] | None = None) -> Pair | None:
    """Share of the samples in which the guard changed the force, per axis; zeros without guard.

    Over all rows, or a window of samples; None where the controller does not tell.
    """
    if not run.guard:
        return 0.0, 0.0
    rows = slice(0, run.rows) if samples is None else rows_of(run, samples)
    if rows is None or run.rows == 0 or "clip_active" not in run:
        return None
    force, moment = np.mean(run["clip_active"][rows], axis=0).tolist()
    return force, moment


def torque_change_rms(run: Run) -> float | None:
    """RMS change of the commanded wheel torques from sample to sample over the last half [N m]."""
    rows = rows_of(run, last_half(run.settings))
    if rows is None:
        return None
    torque = torques(run)
    steps = torque[rows] - torque[rows.start - 1 : rows.stop - 1]
    return float(np.sqrt(np.mean(steps**2)))


def torques(run: Run) -> FloatArray:
    """Both wheels' commanded torques [N m], shape (rows, 2)."""
    return np.stack([run["tau_right"], run["tau_left"]], axis=1)


def _rms_distance(run: Run, samples: tuple[int, int]) -> float | None:
    rows = rows_of(run, samples)
    return None if rows is None else float(np.sqrt(np.mean(distance(run)[rows] ** 2)))
