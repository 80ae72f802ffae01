"""Numbers of a run that only a campaign asks for; each is None where the run has none."""

from __future__ import annotations

import numpy as np

from wmr_ctrl.results import Run, distance, rises, weight_norm, window

LATE = (30.0, 40.0)
"""The last seconds before the paper's change of parameters [s]."""


def distance_at_start(run: Run) -> float | None:
    """Distance from the reference at t = 0 [m]."""
    return float(distance(run)[0]) if run.rows else None


def distance_rms(run: Run, start: float, end: float) -> float | None:
    """RMS of the distance from the reference over [start, end) [m]."""
    rows = window(run, start, end)
    if rows is None or rows.start == rows.stop:
        return None
    return float(np.sqrt(np.mean(distance(run)[rows] ** 2)))


def halving_time(run: Run) -> float | None:
    """First sample time at which the distance is at most half of that at the start [s]."""
    gap = distance(run)
    reached = np.flatnonzero(gap <= 0.5 * gap[0]) if run.rows else np.array([])
    return float(run.time[reached[0]]) if reached.size else None


def limit_ratio(run: Run) -> float:
    """Largest |v_i| over its limit v_u1_i, over both axes and every plant step [1]."""
    pairs = zip(run.monitor.max_abs_v, run.settings.v_u1, strict=True)
    return max(value / limit for value, limit in pairs)


def violated(run: Run) -> float:
    """1.0 if a velocity was ever beyond its limit, else 0.0; the mean over runs is their share."""
    return float(run.monitor.violations > 0)


def violations(run: Run) -> float:
    """Number of plant steps beyond a limit."""
    return float(run.monitor.violations)


def first_violation(run: Run) -> float | None:
    """Time of the first violation [s]."""
    event = run.monitor.first_violation
    return None if event is None else event[0]


def barrier_at_start(run: Run) -> float | None:
    """The barrier function V1, Eq. (12), at the first sample."""
    return float(run["V1"][0]) if run.rows else None


def barrier_late(run: Run) -> float | None:
    """Mean of V1 over 30-40 s, divided by V1 at the first sample."""
    rows = window(run, *LATE)
    return None if rows is None else _relative(run, float(np.mean(run["V1"][rows])))


def barrier_rises(run: Run) -> float | None:
    """Number of samples before the split at which V1 is larger than one sample earlier."""
    found = rises(run, 0.0, run.settings.split)
    return None if found is None else float(found.count)


def barrier_rise_share(run: Run) -> float | None:
    """Sum of the rises of V1 before the split, divided by V1 at the first sample."""
    found = rises(run, 0.0, run.settings.split)
    return None if found is None else _relative(run, found.total)


def weights(run: Run, axis: int, when: str) -> float | None:
    """Norm of the network's weights of an axis (0 or 1), at the ``end`` or its ``largest``."""
    found = weight_norm(run)
    if found is None:
        return None
    return (found.end if when == "end" else found.largest)[axis]


def _relative(run: Run, value: float) -> float | None:
    start = barrier_at_start(run)
    return value / start if start else None
