"""The figures of a run: integral squared error, RMS errors, torques, and their summary.

Every window is half open, [start, end), over sample times; a run that ended early gives None for
each window that it does not cover to the end.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.results.plain import json_safe
from wmr_ctrl.results.tracking import (
    arrival,
    guard_share,
    position_max,
    position_rms,
    saturated_share,
    torque_change_rms,
    torque_needed_rms,
    torques,
    tracked,
    tracking,
)
from wmr_ctrl.results.windows import span, window

if TYPE_CHECKING:
    from wmr_ctrl.results.run import FloatArray, Run

E_RMS_WINDOWS = ((30, 40), (40, 45), (70, 80))
"""Before, just after and long after the paper's change of parameters [s]."""

PROVENANCE = ("version", "scenario_hash", "kernel_hash")
"""The keys of a run's provenance that the summary repeats."""
COUNTED = ("M_min", "M_max", "dbar", "nbar", "alpha")
"""What it repeats of the numbers that a guard counts on."""
COUPLED = ("master", "delay", "fmu_reference", "fmu_controller", "fmu_guard", "fmu_plant")
"""Those that it repeats of a run that coupled FMUs: who stepped, and names and hashes of files."""


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


@np.errstate(over="ignore", invalid="ignore")
def summary(run: Run) -> dict[str, object]:
    """The run's identity, outcome and figures, as ``wmr-ctrl run --json`` prints them.

    Plain Python values only; None stands for a window that the run did not cover and for a number
    that is not finite.
    """
    figures = {
        "scenario": run.scenario,
        "law": run.law,
        "guard": counted_on(run),
        "seed": run.seed,
        "engine": run.engine,
        "plant": run.settings.plant_kind,
        "outcome": run.outcome.value,
        "ise": ise(run),
        "position_rms": position_rms(run),
        "position_max": position_max(run),
        "tracking": tracking(run),
        "tracked": tracked(run),
        "arrival": arrival(run),
        "guard_share": guard_share(run),
        "usable_speed": run.settings.usable,
        "reference_speed": run.settings.asked,
        "torque_change_rms": torque_change_rms(run),
        "torque_needed_rms": torque_needed_rms(run),
        "saturated_share": saturated_share(run),
        "max_abs_v": run.monitor.max_abs_v,
        "violations": run.monitor.violations,
        "rigid": None if run.monitor.rigid is None else asdict(run.monitor.rigid),
        "d_least": run.monitor.d_least,
        "dbar": run.settings.dbar,
        "tau_peak": tau_peak(run),
        "tau_rms": tau_rms(run),
        "e_rms": {f"{start}-{end}": e_rms(run, start, end) for start, end in E_RMS_WINDOWS},
        "remarks": [asdict(item) for item in run.remarks],
        "provenance": {key: run.provenance.get(key) for key in PROVENANCE}
        | {key: run.provenance[key] for key in COUPLED if key in run.provenance},
    }
    return {key: json_safe(value) for key, value in figures.items()}


def counted_on(run: Run) -> dict[str, object] | None:
    """What a guarded run's guard counted on, in SI units as in `Settings`; None without guard."""
    return {name: getattr(run.settings, name) for name in COUNTED} if run.guard else None


def _torques(run: Run, rows: slice | None) -> FloatArray:
    """Both wheels' commanded torques [N m], shape (rows, 2); empty where there is no window."""
    return torques(run)[rows or slice(0, 0)]
