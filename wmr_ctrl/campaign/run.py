"""Plans run by the engine of all studies; no number of threads changes a result."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from wmr_ctrl.campaign.engine import PhaseProgress, PlannedRun, Refusal, Silent, run_cases
from wmr_ctrl.campaign.table import REFUSED, FigureTable, RunRow, reported
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import Run
from wmr_ctrl.results.figures import FIGURES, values_of
from wmr_ctrl.sim.batch import check_jobs


@dataclass(frozen=True)
class Campaign:
    """A finished plan: ``table`` has a row per run, ``runs`` the whole first run of each case.

    ``runs`` maps (scenario, law) to the Run of the lowest seed.  Without rows: not run.
    """

    table: FigureTable = field(default_factory=FigureTable)
    runs: Mapping[tuple[str, str], Run] = field(default_factory=dict)


def run_campaign(
    plan: Sequence[PlannedRun],
    jobs: int | None = None,
    progress: PhaseProgress | None = None,
    figures: Sequence[str] = (),
    whole: bool = True,
    texts: tuple[str, str] = ("Compiling the laws", "Running the simulations"),
) -> Campaign:
    """Compile, then run all of ``plan`` on ``jobs`` threads (default: one per core).

    Rows have ``figures`` (without: those of the report); ``whole``: keep whole first runs.  A
    guard's refusal becomes a row; that of an unguarded case is raised.  The result is the same for
    any ``jobs``.  An exception in a run, or an interrupt, ends the campaign at once: what has not
    begun is dropped.  Raises ArgumentError for jobs < 1 or an empty plan.
    """
    check_jobs(jobs)
    if not plan:
        raise ArgumentError("the plan is empty: name at least one law and one seed.")
    taken = [FIGURES[name] for name in figures] or reported()
    first = _first_seeds(plan) if whole else {}
    runs: dict[tuple[str, str], Run] = {}

    def row(place: int, run: Run) -> RunRow:
        case, seed = plan[place]
        if first.get((case.name, case.law)) == seed:
            runs[case.name, case.law] = run
        return RunRow(case, seed, run.outcome.value, values_of(run, taken))

    results = run_cases(plan, row, jobs, progress or Silent(), texts)
    rows = [
        RunRow(*planned, REFUSED, {}, item.text) if isinstance(item, Refusal) else item
        for planned, item in zip(plan, results, strict=True)
    ]
    ordered = {key: runs[key] for key in first if key in runs}  # threads end in any order
    return Campaign(FigureTable(rows), MappingProxyType(ordered))


def _first_seeds(plan: Iterable[PlannedRun]) -> dict[tuple[str, str], int]:
    """The lowest seed of each case's name and law."""
    first: dict[tuple[str, str], int] = {}
    for case, seed in plan:
        key = (case.name, case.law)
        first[key] = min(seed, first.get(key, seed))
    return first
