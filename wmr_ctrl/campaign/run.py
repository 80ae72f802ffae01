"""Running a plan on several threads, in an order that no number of threads can change."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from wmr_ctrl.campaign.plan import Task
from wmr_ctrl.campaign.progress import Progress, Silent
from wmr_ctrl.campaign.rows import Row, row_of
from wmr_ctrl.campaign.table import Table
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.results import Run

Simulate: TypeAlias = Callable[[str, str, int], Run]
"""(scenario, law, seed) -> Run; must be safe to call from several threads at once."""

Prepare: TypeAlias = Callable[[str, str], object]
"""(scenario, law): compiles what :data:`Simulate` will need for them."""

_PATIENCE = 0.1
"""Longest wait before a key press is noticed, where waiting itself cannot be interrupted [s]."""


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
    if jobs is not None and jobs < 1:
        raise ArgumentError(f"jobs = {jobs!r} must be at least 1, or left out for one per core.")
    if not plan:
        raise ArgumentError("the plan is empty: name at least one law and one seed.")
    shown = progress or Silent()
    _prepare_all(prepare, plan, shown)
    first = _first_seeds(plan)
    results = _run_all(simulate, plan, first, jobs or cores(), shown)
    runs = {(run.scenario, run.law): run for _, run in results if run is not None}
    return Campaign(Table(row for row, _ in results), MappingProxyType(runs))


def cores() -> int:
    """Number of cores that this process may use, at least 1."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) or 1
    return os.cpu_count() or 1


def _prepare_all(prepare: Prepare, plan: Iterable[Task], progress: Progress) -> None:
    pairs = tuple(dict.fromkeys((task.scenario, task.law) for task in plan))
    progress.start(len(pairs), "Compiling the laws")
    try:
        for scenario, law in pairs:
            prepare(scenario, law)
            progress.advance(1)
    finally:
        progress.done()


def _first_seeds(plan: Iterable[Task]) -> frozenset[Task]:
    """The task of the lowest seed of each scenario and law."""
    first: dict[tuple[str, str], Task] = {}
    for task in plan:
        known = first.setdefault((task.scenario, task.law), task)
        if task.seed < known.seed:
            first[task.scenario, task.law] = task
    return frozenset(first.values())


_Result: TypeAlias = tuple[Row, Run | None]


def _run_all(
    simulate: Simulate, plan: Sequence[Task], kept: frozenset[Task], jobs: int, progress: Progress
) -> list[_Result]:
    def one(task: Task) -> _Result:
        run = simulate(task.scenario, task.law, task.seed)
        return row_of(run), run if task in kept else None

    progress.start(len(plan), "Running the simulations")
    pool = ThreadPoolExecutor(jobs, thread_name_prefix="campaign")
    try:
        futures = [pool.submit(one, task) for task in plan]
        _follow(futures, progress)
        return [future.result() for future in futures]
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        progress.done()


def _follow(futures: Sequence[Future[_Result]], progress: Progress) -> None:
    """Report each future as it ends; raise the first exception that one of them ends with."""
    pending = set(futures)
    while pending:
        ended, pending = wait(pending, timeout=_PATIENCE, return_when=FIRST_COMPLETED)
        for future in ended:
            future.result()
        if ended:
            progress.advance(len(ended))
