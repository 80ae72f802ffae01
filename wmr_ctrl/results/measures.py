"""Quantities from a run's log: tracking errors, torques, the guard's share, the barrier.

Every window is half open, [start, end), over sample times; a run that ended early gives None for
each window that it does not cover to the end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import windows

if TYPE_CHECKING:
    from .run import Floats, Run

Pair = tuple[float, float]
AT_LIMIT = 1 - 1e-9
"""Share of the torque limit that is the limit, but for rounding."""


@dataclass(frozen=True)
class Rises:
    """Increases between samples: their number, their sum, the largest of them."""

    count: int
    total: float
    largest: float


def distance(run: Run) -> Floats:
    """Distance of the robot from its reference point [m] at each sample, shape (N,)."""
    return np.hypot(run["x"] - run["x_d"], run["y"] - run["y_d"])


def torques(run: Run) -> Floats:
    """Both wheels' commanded torques [N m], shape (rows, 2)."""
    return np.stack([run["tau_right"], run["tau_left"]], axis=1)


def distance_at_start(run: Run) -> float | None:
    """Distance at the first sample [m]; None without any."""
    return float(distance(run)[0]) if run.rows else None


def distance_over(run: Run, span: tuple[float, float], *, largest: bool = False) -> float | None:
    """RMS of the distance from the reference over [start, end) [m], or the largest."""
    sizes = _distances(run, windows.window(run, *span))
    return sizes["position_max" if largest else "position_rms"]


def halving_time(run: Run) -> float | None:
    """First sample time at which the distance is at most half of that at the start [s]."""
    gap = distance(run)
    reached = np.flatnonzero(gap <= 0.5 * gap[0]) if run.rows else np.array([])
    return float(run.time[reached[0]]) if reached.size else None


def ise_over(run: Run, start: float, end: float, *, position: bool = False) -> float | None:
    """Sum of (dx^2 + dy^2 + dtheta^2) * control over [start, end), true pose less reference.

    With ``position`` without the angle, then in m^2 s; else m^2 s and rad^2 s mixed one to one.
    """
    rows = windows.window(run, start, end)
    if rows is None:
        return None
    names = ("x", "y") if position else ("x", "y", "theta")
    squares = sum(float(np.sum((run[name] - run[f"{name}_d"])[rows] ** 2)) for name in names)
    return squares * run.settings.control


def ise(run: Run) -> dict[str, float | None]:
    """Integral squared errors: ``total``, ``before`` and ``after`` the split, and ``position``."""
    split, duration = run.settings.split, run.settings.duration
    return {
        "total": ise_over(run, 0, duration),
        "before": ise_over(run, 0, split),
        "after": ise_over(run, split, duration),
        "position": ise_over(run, 0, duration, position=True),
    }


def ise_orientation(run: Run) -> float | None:
    """Integral squared error of theta alone over the whole run [rad2 s]."""
    parts = ise(run)
    total, position = parts["total"], parts["position"]
    return None if total is None or position is None else total - position


def mean_e1(run: Run, span: tuple[float, float]) -> float | None:
    """Mean of |e1| over [start, end) [m]."""
    rows = windows.window(run, *span)
    return None if rows is None else float(np.mean(np.abs(run["e"][rows, 0])))


def e_rms(run: Run, start: float, end: float) -> tuple[float, float, float] | None:
    """RMS over [start, end) of the tracking errors e1 [m], e2 [m], e3 [rad] of Eq. (8).

    As in the paper, e3 includes whole turns.
    """
    rows = windows.window(run, start, end)
    if rows is None or rows.start == rows.stop:
        return None
    ahead, aside, angle = np.sqrt(np.mean(run["e"][rows] ** 2, axis=0)).tolist()
    return ahead, aside, angle


def heading_error(run: Run) -> Floats:
    """e3 of Eq. (8) in (-pi, pi] [rad], without the whole turns that Eq. (8) includes."""
    e3: Floats = run["e"][:, 2]
    return np.where(np.abs(e3) > np.pi, np.arctan2(np.sin(e3), np.cos(e3)), e3)


def distances(run: Run, samples: windows.Span) -> dict[str, float | None]:
    """RMS and largest distance from the desired position over a window of samples [m]."""
    return _distances(run, windows.rows_of(run, samples))


def _distances(run: Run, rows: slice | None) -> dict[str, float | None]:
    if rows is None or rows.start == rows.stop:
        return {"position_rms": None, "position_max": None}
    gap = distance(run)[rows]
    return {"position_rms": float(np.sqrt(np.mean(gap**2))), "position_max": float(np.max(gap))}


def position_rms(run: Run) -> dict[str, float | None]:
    """RMS distance from the desired position [m]: over ``all`` samples and the ``last_quarter``."""
    spans = {"all": (0, run.settings.samples), "last_quarter": windows.last_quarter(run.settings)}
    return {name: distances(run, span)["position_rms"] for name, span in spans.items()}


def position_max(run: Run) -> float | None:
    """Largest distance from the desired position over the last quarter [m]."""
    return distances(run, windows.last_quarter(run.settings))["position_max"]


def tracking(run: Run) -> dict[str, dict[str, float | None] | None]:
    """RMS and largest distance from the desired position [m]: in the ``drive`` and at the ``end``.

    The end is the time after the arrival of a path that stops; None without one.
    """
    end = windows.at_rest(run.settings)
    return {
        "drive": distances(run, windows.drive(run.settings)),
        "end": distances(run, end) if end[0] < end[1] else None,
    }


def tracked(run: Run) -> bool | None:
    """True if the position's RMS is within metrics.tolerance, over the drive and over the end.

    False for a run that ended early, None where the tolerance is not known.
    """
    allowed = run.settings.tolerance
    if allowed is None:
        return None
    parts = [part["position_rms"] for part in tracking(run).values() if part is not None]
    return all(value is not None and value <= allowed for value in parts)


def arrival(run: Run) -> dict[str, float | None] | None:
    """Times at which ``reference`` and ``robot`` reach the goal [s]; None without a goal.

    The robot's is the first sample from which it stays within metrics.tolerance of the goal until
    the run ends; None if it never does, or the run ends before the reference arrives.
    """
    settings = run.settings
    if settings.arrival is None:
        return None
    there = None
    if settings.tolerance is not None and run.rows > settings.index(settings.arrival):
        away = np.hypot(run["x"] - run["x_d"][-1], run["y"] - run["y_d"][-1])
        there = _stays(run, away, settings.tolerance)
    lasted = windows.covered(run) == run.rows
    return {"reference": settings.arrival, "robot": there if lasted else None}


def settling_time(run: Run, within: float) -> float | None:
    """First sample time [s] from which the distance stays <= ``within`` [m] to the end.

    None for a run that ended early, or whose last sample is farther away.
    """
    if windows.covered(run) < run.settings.samples:
        return None
    return _stays(run, distance(run), within)


def _stays(run: Run, gap: Floats, within: float) -> float | None:
    """First sample time [s] from which ``gap`` stays <= ``within``; None if the last is not."""
    outside = np.flatnonzero(~(gap <= within))
    first = int(outside[-1]) + 1 if outside.size else 0
    return float(run.time[first]) if first < run.rows else None


def guard_share(run: Run, samples: windows.Span | None = None) -> Pair | None:
    """Share of the samples in which the guard changed the force, per axis; zeros without guard.

    Over all rows, or a window of samples; None if the controller does not report it.
    """
    return _changed_share(run, samples) if run.guard else (0.0, 0.0)


def filter_share(run: Run, samples: windows.Span | None = None) -> Pair | None:
    """Share of the samples in which the filter changed v and omega; zeros without filter.

    Over all rows, or a window of samples; None if the controller does not report it.
    """
    return _changed_share(run, samples) if "filter_flags" in run else (0.0, 0.0)


def _changed_share(run: Run, samples: windows.Span | None = None) -> Pair | None:
    rows = slice(0, run.rows) if samples is None else windows.rows_of(run, samples)
    if rows is None or run.rows == 0 or "clip_active" not in run:
        return None
    first, second = np.mean(run["clip_active"][rows], axis=0).tolist()
    return first, second


def tau_peak(run: Run, start: float = 0.0, end: float | None = None) -> float | None:
    """Largest |commanded wheel torque| [N m] over [start, end), by default over all rows."""
    torque = torques(run)[windows.window(run, start, end) or slice(0, 0)]
    return float(np.max(np.abs(torque))) if torque.size else None


def tau_rms(run: Run, start: float | None = None, end: float | None = None) -> float | None:
    """RMS [N m] of both commanded wheel torques together over [start, end).

    By default from ``rms_from`` to the end of the duration.
    """
    begin = run.settings.rms_from if start is None else start
    rows = windows.window(run, begin, run.settings.duration if end is None else end)
    torque = torques(run)[rows or slice(0, 0)]
    return float(np.sqrt(np.mean(torque**2))) if torque.size else None


def torque_change_rms(run: Run) -> float | None:
    """RMS change of the commanded wheel torques from sample to sample, while `working` [N m]."""
    rows = windows.rows_of(run, windows.working(run.settings))
    return None if rows is None else change_rms(torques(run), rows)


def change_rms(torque: Floats, rows: slice) -> float:
    """RMS over rows and wheels of the torques' (N, 2) change since the previous row [N m]."""
    steps = torque[rows] - torque[rows.start - 1 : rows.stop - 1]
    return float(np.sqrt(np.mean(steps**2)))


def torque_needed_rms(run: Run) -> float | None:
    """RMS of the wheel torques that the desired motion needs, while `working` [N m]."""
    rows, needed = windows.rows_of(run, windows.working(run.settings)), run.needed
    return None if rows is None or needed is None else float(np.sqrt(np.mean(needed[rows] ** 2)))


def saturated_share(run: Run) -> float | None:
    """Share of the samples with a wheel at its torque limit, while `working`."""
    rows, outlook = windows.rows_of(run, windows.working(run.settings)), run.outlook
    if rows is None or outlook is None:
        return None
    largest = np.max(np.abs(torques(run)[rows]), axis=1)
    return float(np.mean(largest >= AT_LIMIT * outlook.tau_max))


def limit_ratios(run: Run) -> Pair:
    """Largest |v1| and |omega| divided by their limits [1]."""
    (linear, angular), limits = run.monitor.max_abs_v, run.settings.v_u1
    return linear / limits[0], angular / limits[1]


def velocity_sway(run: Run) -> Pair | None:
    """Standard deviation of v1 and omega from the desired ones, divided by their limits [1]."""
    rows = windows.rows_of(run, windows.working(run.settings))
    if rows is None:
        return None
    off = (run["v1"] - run["v1_d"])[rows], (run["omega"] - run["v2_d"])[rows]
    linear, angular = run.settings.v_u1
    return float(np.std(off[0])) / linear, float(np.std(off[1])) / angular


def rises(run: Run, start: float = 0.0, end: float | None = None) -> Rises | None:
    """Rises of the barrier function V1, Eq. (12), within [start, end) [s].

    Without ``end``, up to the last row; None where the run does not cover the window.
    """
    rows = windows.window(run, start, end)
    if rows is None:
        return None
    steps = np.diff(run["V1"][rows])
    up = steps[steps > 0]
    return Rises(len(up), float(np.sum(up)), float(np.max(up, initial=0.0)))


def barrier(run: Run) -> dict[str, float | None]:
    """V1 at the ``start``, and the number of its ``rises`` before the split.

    Divided by V1 at the start: ``late``, its mean over 30-40 s; ``rise_share``, the rises' sum.
    """
    start = float(run["V1"][0]) if run.rows else None
    rows, climb = windows.window(run, *windows.BEFORE), rises(run, 0.0, run.settings.split)
    late = float(np.mean(run["V1"][rows])) / start if rows and start else None
    count = None if climb is None else climb.count
    share = climb.total / start if climb and start else None
    return {"start": start, "late": late, "rises": count, "rise_share": share}


def weight_norm(run: Run) -> dict[str, list[float]] | None:
    """Norm of the weights [1] by axis at the ``end``, and the ``largest`` over the run.

    None for a law without weights or an empty run.
    """
    if "W_norm" not in run or run.rows == 0:
        return None
    norms = run["W_norm"]
    return {"end": norms[-1].tolist(), "largest": np.max(norms, axis=0).tolist()}
