"""Tube of a run: the certified corridor of its scenario and law, as a band about the path."""

from __future__ import annotations

import numpy as np

from wmr_ctrl.corridor import Corridor, find_corridor, run_corridor
from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.report.course import scenario_behind
from wmr_ctrl.results import FloatArray, Run
from wmr_ctrl.scenario import override

FAINT = 0.25
"""Opacity of a band."""


def tube_of(run: Run) -> Corridor | None:
    """The certified corridor of the run's scenario and law, where there is one.

    None on the rigid body too: the certificate is about the plane model.  Where it is of drives and
    commands that hold something at the start, which runs do not, it is that of the whole run.
    """
    if run.monitor.rigid:
        return None
    return corridor_behind(run)


def course_of_tube(run: Run) -> FloatArray | None:
    """Certified distance [m] and heading [rad] (2, rows) over the run's time; None without.

    Where one corridor does not hold for all of the run, each sample has its own.
    """
    scenario = None if run.monitor.rigid else scenario_behind(run)
    if scenario is None or run.law not in LAWS:
        return None
    known = tube_of(run)
    if known is not None and known.until is None and known.run is None:
        return np.tile([[known.position or 0.0], [known.heading or 0.0]], run.rows)
    whole = run_corridor(override(scenario, {"guard.enabled": run.guard}), run.law)
    if whole.course is None:
        if known is None or known.run is not None:
            return None
        course = np.full((2, run.rows), np.nan)
        course[:, : run.settings.index(known.until or 0.0)] = [
            [known.position or 0.0],
            [known.heading or 0.0],
        ]
        return course
    return whole.course[:, np.minimum(np.arange(run.rows), whole.course.shape[1] - 1)]


def corridor_behind(run: Run) -> Corridor | None:
    """The same, whichever plant the run had."""
    scenario = scenario_behind(run)
    if scenario is None or run.law not in LAWS:
        return None
    guarded = override(scenario, {"guard.enabled": run.guard})
    tube = find_corridor(guarded, run.law)
    if tube.position is not None and tube.late:
        tube = run_corridor(guarded, run.law)
    return tube if tube.position is not None else None


def band(path: FloatArray, width: float | FloatArray) -> FloatArray:
    """Corners (2, 2n) of the band within ``width`` [m], also (n), of a path (2, n)."""
    ahead = np.gradient(path, axis=1)
    side = width * np.array((-ahead[1], ahead[0])) / np.hypot(*ahead)
    return np.hstack([path + side, (path - side)[:, ::-1]])
