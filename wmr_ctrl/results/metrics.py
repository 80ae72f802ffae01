"""The figures of a run: integral squared error, RMS errors, torques.

Every window is half open, [start, end), over sample times; a run that ended early gives None for
each window that it does not cover to the end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.tracking import (
    torques,
)
from wmr_ctrl.results.windows import span, window

if TYPE_CHECKING:
    from wmr_ctrl.results.run import FloatArray, Run


def ise_over(run: Run, start: float, end: float, *, position: bool = False) -> float | None:
    """Sum of (dx^2 + dy^2 + dtheta^2) * control over [start, end), true pose less reference.

    With ``position`` without the angle, then in m^2 s; else m^2 s and rad^2 s mixed one to one.
    """
    rows = window(run, start, end)
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


def e_rms(run: Run, start: float, end: float) -> tuple[float, float, float] | None:
    """RMS over [start, end) of the tracking errors e1 [m], e2 [m], e3 [rad] of Eq. (8)."""
    rows = window(run, start, end)
    if rows is None or rows.start == rows.stop:
        return None
    ahead, aside, angle = np.sqrt(np.mean(run["e"][rows] ** 2, axis=0)).tolist()
    return ahead, aside, angle


def tau_peak(run: Run, start: float = 0.0, end: float | None = None) -> float | None:
    """Largest |commanded wheel torque| [N m] over [start, end), by default over all rows."""
    torque = _torques(run, span(run, start, end))
    return float(np.max(np.abs(torque))) if torque.size else None


def tau_rms(run: Run, start: float | None = None, end: float | None = None) -> float | None:
    """RMS [N m] of both commanded wheel torques together over [start, end).

    By default from ``rms_from`` to the end of the duration.
    """
    begin = run.settings.rms_from if start is None else start
    torque = _torques(run, window(run, begin, run.settings.duration if end is None else end))
    return float(np.sqrt(np.mean(torque**2))) if torque.size else None


def _torques(run: Run, rows: slice | None) -> FloatArray:
    """Both wheels' commanded torques [N m], shape (rows, 2); empty where there is no window."""
    return torques(run)[rows or slice(0, 0)]
