"""The paper's plan, run by the engine of all studies; no number of threads changes a result."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from wmr_ctrl.campaign.engine import PhaseProgress, Refusal, Silent, run_cases
from wmr_ctrl.campaign.plan import PlannedRun
from wmr_ctrl.campaign.table import FigureRow, FigureTable, row_of
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import Run
from wmr_ctrl.sim.batch import check_jobs


@dataclass(frozen=True)
class Campaign:
    """A finished plan: ``table`` has a row per run, ``runs`` the whole first run of each case.

    ``runs`` maps (scenario, law) to the Run of the lowest seed.
    """

    table: FigureTable
    runs: Mapping[tuple[str, str], Run]


def run_campaign(
    plan: Sequence[PlannedRun],
    jobs: int | None = None,
    progress: PhaseProgress | None = None,
) -> Campaign:
    """Compile, then run every task of ``plan`` on ``jobs`` threads (default: one per core).

    The result is the same for any ``jobs``.  An exception in a task, or an interrupt, ends the
    campaign at once: tasks that have not begun are dropped.  Raises ArgumentError for jobs < 1 or
    an empty plan.
    """
    check_jobs(jobs)
    if not plan:
        raise ArgumentError("the plan is empty: name at least one law and one seed.")
    shown = progress or Silent()
    first = _first_seeds(plan)

    def result(place: int, run: Run) -> tuple[FigureRow, Run | None]:
        row = replace(row_of(run), scenario=plan[place].scenario)
        return row, run if plan[place] in first else None

    texts = "Compiling the laws", "Running the simulations"
    runs = [(task.case, task.seed) for task in plan]
    results = [
        item
        for item in run_cases(runs, result, jobs, shown, texts)
        if not isinstance(item, Refusal)  # nobody switches a guard on here
    ]
    whole = {(row.scenario, row.law): run for row, run in results if run is not None}
    return Campaign(FigureTable(row for row, _ in results), MappingProxyType(whole))


def _first_seeds(plan: Iterable[PlannedRun]) -> frozenset[PlannedRun]:
    """The task of the lowest seed of each scenario and law."""
    first: dict[tuple[str, str], PlannedRun] = {}
    for task in plan:
        known = first.setdefault((task.scenario, task.law), task)
        if task.seed < known.seed:
            first[task.scenario, task.law] = task
    return frozenset(first.values())
