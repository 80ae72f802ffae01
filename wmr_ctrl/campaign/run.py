"""Running a plan, in an order that no number of threads can change."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol, TypeAlias, TypeVar

from wmr_ctrl.campaign.plan import PlannedRun
from wmr_ctrl.campaign.table import FigureRow, FigureTable, row_of
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import Run
from wmr_ctrl.sim.batch import check_jobs
from wmr_ctrl.sim.ready import Ready

Prepare: TypeAlias = Callable[[str, str], Ready]
"""(scenario, law) -> the loop, compiled."""

T = TypeVar("T")


class PhaseProgress(Protocol):
    """Whatever shows progress; each phase of a job is one ``start``, many ``advance``, ``done``."""

    def start(self, total: int, text: str) -> None:
        """A phase of ``total`` steps begins; ``text`` says what it does."""

    def advance(self, count: int = 1) -> None:
        """``count`` further steps of the phase are done."""

    def done(self) -> None:
        """The phase is over, finished or given up."""


class Silent:
    """Progress that nobody looks at."""

    def start(self, total: int, text: str) -> None:
        """Show nothing."""

    def advance(self, count: int = 1) -> None:
        """Show nothing."""

    def done(self) -> None:
        """Show nothing."""


class Simulate(Protocol):
    """Runs many loops at a time, such as `wmr_ctrl.sim.many.run_each`."""

    def __call__(
        self,
        runs: Sequence[tuple[Ready, int]],
        then: Callable[[int, Run], T],
        jobs: int | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> list[T]:
        """What ``then`` makes of place and Run of each (loop, seed), in their order."""


@dataclass(frozen=True)
class Campaign:
    """A finished plan: ``table`` has a row per run, ``runs`` the whole first run of each case.

    ``runs`` maps (scenario, law) to the Run of the lowest seed.
    """

    table: FigureTable
    runs: Mapping[tuple[str, str], Run]


def run_campaign(
    simulate: Simulate,
    prepare: Prepare,
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
    loops = _prepare_all(prepare, plan, shown)
    first = _first_seeds(plan)

    def result(place: int, run: Run) -> tuple[FigureRow, Run | None]:
        return row_of(run), run if plan[place] in first else None

    runs = [(loops[task.scenario, task.law], task.seed) for task in plan]
    results = followed(simulate, runs, result, jobs, shown, "Running the simulations")
    whole = {(run.scenario, run.law): run for _, run in results if run is not None}
    return Campaign(FigureTable(row for row, _ in results), MappingProxyType(whole))


def followed(
    simulate: Simulate,
    runs: Sequence[tuple[Ready, int]],
    then: Callable[[int, Run], T],
    jobs: int | None,
    progress: PhaseProgress,
    text: str,
) -> list[T]:
    """What ``simulate`` gives, as a phase of ``progress`` that counts the runs."""
    done = 0

    def advance_to(share: float) -> None:
        nonlocal done
        count = round(share * len(runs)) - done
        done += count
        progress.advance(count)

    progress.start(len(runs), text)
    try:
        return simulate(runs, then, jobs, advance_to)
    finally:
        progress.done()


def _prepare_all(
    prepare: Prepare, plan: Iterable[PlannedRun], progress: PhaseProgress
) -> dict[tuple[str, str], Ready]:
    pairs = tuple(dict.fromkeys((task.scenario, task.law) for task in plan))
    loops = {}
    progress.start(len(pairs), "Compiling the laws")
    try:
        for pair in pairs:
            loops[pair] = prepare(*pair)
            progress.advance(1)
    finally:
        progress.done()
    return loops


def _first_seeds(plan: Iterable[PlannedRun]) -> frozenset[PlannedRun]:
    """The task of the lowest seed of each scenario and law."""
    first: dict[tuple[str, str], PlannedRun] = {}
    for task in plan:
        known = first.setdefault((task.scenario, task.law), task)
        if task.seed < known.seed:
            first[task.scenario, task.law] = task
    return frozenset(first.values())
