"""The comparison's runs, reduced to a row per case."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from wmr_ctrl.campaign.ours import Case
from wmr_ctrl.campaign.run import cores
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.results import Run, ise, tau_peak, window

SCENARIO = "paper-simulation"

SimulateCase: TypeAlias = Callable[[str, str, int, bool, Mapping[str, Any]], Run]
"""(scenario, law, seed, guard, overrides) -> Run; safe to call from several threads."""

REFUSED = "refused"
BEFORE, AFTER = (30.0, 40.0), (70.0, 80.0)


@dataclass(frozen=True, slots=True)
class Comparison:
    """One case: outcome ("refused" where the guard's bounds cannot be met) and its figures.

    ``ise`` [m2 s + rad2 s]; ``e1_before``, ``e1_after``: mean |e1| [m] over 30-40 s and 70-80 s;
    ``tau_peak`` [N m]; ``speed`` (2): largest |v_i|/v_u1_i; ``clipped`` (2): share of samples in
    which the guard acted.  None where a run has none.
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


def compare_laws(
    simulate: SimulateCase,
    plan: Sequence[Case],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[Comparison, ...]:
    """Run every case; the rows are in the plan's order for any number of ``jobs``."""
    rows: list[Comparison] = []
    with ThreadPoolExecutor(jobs or cores()) as pool:
        for row in pool.map(lambda case: _row(simulate, case), plan):
            rows.append(row)
            if progress:
                progress(len(rows) / len(plan))
    return tuple(rows)


def _row(simulate: SimulateCase, case: Case) -> Comparison:
    try:
        run = simulate(SCENARIO, case.law, case.seed, case.guard, case.overrides)
    except ScenarioError:
        if not case.guard:
            raise
        return Comparison(case, REFUSED)
    return comparison_of(case, run)


def comparison_of(case: Case, run: Run) -> Comparison:
    """The row of a finished run."""
    ratios = tuple(v / u for v, u in zip(run.monitor.max_abs_v, run.settings.v_u1, strict=True))
    clipped = run["clip_active"].mean(axis=0) if "clip_active" in run and run.rows else None
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
