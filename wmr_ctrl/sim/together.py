"""Whole Runs, many at a time: what laws compiled for lanes leave becomes Runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from wmr_ctrl.results import Monitor, Run
from wmr_ctrl.sim.batch import Columns, Task, run_logged
from wmr_ctrl.sim.finish import finished
from wmr_ctrl.sim.native import columns_of
from wmr_ctrl.sim.ready import Ready

T = TypeVar("T")


def run_each(
    runs: Sequence[tuple[Ready, int]],
    then: Callable[[int, Run], T],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[T]:
    """What ``then`` makes of the place and the Run of each pair (law, seed), in their order.

    Several robots run at a time on each of ``jobs`` threads (default: one per core), in which
    ``then`` is called too; results do not depend on the number.  ``progress`` is called with the
    share done.  Ctrl-C ends all threads within a sample.  Raises CompilerError.
    """
    tasks = [Task(item, seed) for item, seed in runs]

    def made(place: int, columns: Columns, watched: Monitor) -> T:
        item, seed = runs[place]
        found = (columns_of(item.kernels.manifest), columns, watched)
        facts = {"kernel_hash": item.kernels.digest}
        run = finished(item.scenario, item.law, seed, "lanes", found, facts, item.bounds)
        return then(place, run)

    return run_logged(tasks, made, jobs=jobs, progress=progress)
