"""A run of the comparison, reduced to a row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.campaign.ours import Case
from wmr_ctrl.results import Run, ise, tau_peak, window

SCENARIO = "paper-simulation"

REFUSED = "refused"
BEFORE, AFTER = (30.0, 40.0), (70.0, 80.0)


@dataclass(frozen=True, slots=True)
class Comparison:
    """One case: outcome ("refused" where the guard's bounds cannot be met) and its figures.

    ``ise`` [m2 s + rad2 s]; ``e1_before``, ``e1_after``: mean |e1| [m] over 30-40 s and 70-80 s;
    ``tau_peak`` [N m]; ``speed`` (2): largest |v_i|/v_u1_i; ``clipped`` (2): share of samples in
    which the guard acted, for guarded runs.  None where a run has none.
    """

    case: Case
    outcome: str
    violations: int = 0
    speed: tuple[float, float] | None = None
    ise: float | None = None
    e1_before: float | None = None
    e1_after: float | None = None
    tau_peak: float | None = None
    clipped: tuple[float, float] | None = None


def comparison_of(case: Case, run: Run) -> Comparison:
    """The row of a finished run."""
    ratios = tuple(v / u for v, u in zip(run.monitor.max_abs_v, run.settings.v_u1, strict=True))
    clipped = run["clip_active"].mean(axis=0) if run.guard and run.rows else None
    return Comparison(
        case,
        run.outcome.value,
        run.monitor.violations,
        (ratios[0], ratios[1]),
        ise(run)["total"],
        _mean_e1(run, *BEFORE),
        _mean_e1(run, *AFTER),
        tau_peak(run),
        None if clipped is None else (float(clipped[0]), float(clipped[1])),
    )


def _mean_e1(run: Run, start: float, end: float) -> float | None:
    rows = window(run, start, end)
    return None if rows is None else float(np.mean(np.abs(run["e"][rows, 0])))
