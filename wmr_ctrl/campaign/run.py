"""Running a plan, in an order that no number of threads can change."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias, TypeVar

from wmr_ctrl.campaign.plan import Task
from wmr_ctrl.campaign.progress import Progress, Silent
from wmr_ctrl.campaign.rows import Row, row_of
from wmr_ctrl.campaign.table import Table
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import Run
from wmr_ctrl.sim.batch import check_jobs

Loop: TypeAlias = Any
"""A law on a scenario, ready to run; whatever :data:`Prepare` gives and :class:`Simulate` takes."""

Prepare: TypeAlias = Callable[[str, str], Loop]
"""(scenario, law) -> the loop, compiled."""

T = TypeVar("T")


class Simulate(Protocol):
    """Runs many loops at a time, such as `wmr_ctrl.sim.together.run_each`."""

    def __call__(
        self,
        runs: Sequence[tuple[Loop, int]],
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

    table: Table
    runs: Mapping[tuple[str, str], Run]


def run_campaign(
    simulate: Simulate,
    prepare: Prepare,
    plan: Sequence[Task],
    jobs: int | None = None,
    progress: Progress | None = None,
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
    kept = _first_seeds(plan)

    def result(place: int, run: Run) -> tuple[Row, Run | None]:
        return row_of(run), run if plan[place] in kept else None

    runs = [(loops[task.scenario, task.law], task.seed) for task in plan]
    results = followed(simulate, runs, result, jobs, shown, "Running the simulations")
    whole = {(run.scenario, run.law): run for _, run in results if run is not None}
    return Campaign(Table(row for row, _ in results), MappingProxyType(whole))


def followed(
    simulate: Simulate,
    runs: Sequence[tuple[Loop, int]],
    then: Callable[[int, Run], T],
    jobs: int | None,
    progress: Progress,
    text: str,
) -> list[T]:
    """What ``simulate`` gives, as a phase of ``progress`` that counts the runs."""
    done = 0

    def told(share: float) -> None:
        nonlocal done
        count = round(share * len(runs)) - done
        done += count
        progress.advance(count)

    progress.start(len(runs), text)
    try:
        return simulate(runs, then, jobs, told)
    finally:
        progress.done()


def _prepare_all(
    prepare: Prepare, plan: Iterable[Task], progress: Progress
) -> dict[tuple[str, str], Loop]:
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


def _first_seeds(plan: Iterable[Task]) -> frozenset[Task]:
    """The task of the lowest seed of each scenario and law."""
    first: dict[tuple[str, str], Task] = {}
    for task in plan:
        known = first.setdefault((task.scenario, task.law), task)
        if task.seed < known.seed:
            first[task.scenario, task.law] = task
    return frozenset(first.values())
