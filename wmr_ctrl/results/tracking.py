"""How well a run tracked and what that took: position, the guard's share, the torques.

A path that stops is judged over its drive, less the first half in which the start fades, and over
what follows its arrival; a motion that goes on for ever over the run's end.  So a longer run
at rest hides no error of the drive.  A figure is None for a run that ended before its window did.
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


def drive(settings: Settings) -> tuple[int, int]:
    """Samples [first, end) in which driving is judged: the last quarter of a motion without end.

    Of a path that stops, all from half of the time until its arrival on.
    """
    if settings.arrival is None:
        return last_quarter(settings)
    goal = settings.index(settings.arrival)
    return goal // 2, min(goal, settings.samples)


def driving(run: Run) -> str:
    """The window of the drive, in words."""
    if run.settings.arrival is None:
        return "last quarter"
    first, end = (sample * run.settings.control for sample in drive(run.settings))
    return f"drive ({first:.4g} to {end:.4g} s)"


def at_rest(settings: Settings) -> tuple[int, int]:
    """Samples [first, end) from the arrival of a path that stops on; empty where none does."""
    goal = settings.samples if settings.arrival is None else settings.index(settings.arrival)
    return min(goal, settings.samples), settings.samples


def working(settings: Settings) -> tuple[int, int]:
    """Samples [first, end) in which torques are judged, without the very first sample.

    The last half of a motion without end, and the drive of a path that stops.
    """
    first, end = drive(settings)
    return max(settings.samples // 2 if settings.arrival is None else first, 1), end


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


def tracking(run: Run) -> dict[str, dict[str, float | None] | None]:
    """RMS and largest distance from the desired position [m]: in the ``drive`` and at the ``end``.

    The end is what follows the arrival of a path that stops; None where there is none.
    """
    end = at_rest(run.settings)
    return {
        "drive": _distances(run, drive(run.settings)),
        "end": _distances(run, end) if end[0] < end[1] else None,
    }


def tracked(run: Run) -> bool | None:
    """Whether the position's RMS is within metrics.tolerance, over the drive and over the end.

    False for a run that ended early, None where the tolerance is not known.
    """
    allowed = run.settings.tolerance
    if allowed is None:
        return None
    parts = [part["position_rms"] for part in tracking(run).values() if part is not None]
    return all(value is not None and value <= allowed for value in parts)


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
    """RMS change of the commanded wheel torques from sample to sample, while `working` [N m]."""
    rows = rows_of(run, working(run.settings))
    if rows is None:
        return None
    return change_rms(torques(run), rows)


def change_rms(torque: FloatArray, rows: slice) -> float:
    """RMS over rows and wheels of what a torque (N, 2) changes since the row before [N m]."""
    steps = torque[rows] - torque[rows.start - 1 : rows.stop - 1]
    return float(np.sqrt(np.mean(steps**2)))


def torque_needed_rms(run: Run) -> float | None:
    """RMS of the wheel torques that the desired motion needs, while `working` [N m]."""
    rows, needed = rows_of(run, working(run.settings)), run.needed
    return None if rows is None or needed is None else float(np.sqrt(np.mean(needed[rows] ** 2)))


AT_LIMIT = 1 - 1e-9
"""Share of the torque limit that is the limit, but for rounding."""


def saturated_share(run: Run) -> float | None:
    """Share of the samples in which a wheel is at its torque limit, while `working`."""
    rows, outlook = rows_of(run, working(run.settings)), run.outlook
    if rows is None or outlook is None:
        return None
    largest = np.max(np.abs(torques(run)[rows]), axis=1)
    return float(np.mean(largest >= AT_LIMIT * outlook.tau_max))


def velocity_sway(run: Run) -> Pair | None:
    """Standard deviation of v1 and omega about the desired ones, over their limits [1]."""
    rows = rows_of(run, working(run.settings))
    if rows is None:
        return None
    pairs = zip((("v1", "v1_d"), ("omega", "v2_d")), run.settings.v_u1, strict=True)
    linear, angular = (
        float(np.std((run[name] - run[desired])[rows])) / limit for (name, desired), limit in pairs
    )
    return linear, angular


def torques(run: Run) -> FloatArray:
    """Both wheels' commanded torques [N m], shape (rows, 2)."""
    return np.stack([run["tau_right"], run["tau_left"]], axis=1)


def _distances(run: Run, samples: tuple[int, int]) -> dict[str, float | None]:
    rows = rows_of(run, samples)
    most = None if rows is None else float(np.max(distance(run)[rows]))
    return {"position_rms": _rms_distance(run, samples), "position_max": most}


def _rms_distance(run: Run, samples: tuple[int, int]) -> float | None:
    rows = rows_of(run, samples)
    return None if rows is None else float(np.sqrt(np.mean(distance(run)[rows] ** 2)))
