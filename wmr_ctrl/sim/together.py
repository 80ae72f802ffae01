"""Whole Runs, many at a time: what laws compiled for lanes leave becomes Runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from wmr_ctrl.results import Monitor, Run
from wmr_ctrl.sim.batch import Floats, Task, run_logged
from wmr_ctrl.sim.finish import finished
from wmr_ctrl.sim.native import split_columns
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

    def pass_on(place: int, rows: Floats, watched: Monitor) -> T:
        item, seed = runs[place]
        signals = item.compiled.layout.columns
        logged = (signals, split_columns(signals, rows), watched)
        facts = {"kernel_hash": item.compiled.digest}
        return then(
            place, finished(item.scenario, item.law, seed, "lanes", logged, facts, item.bounds)
        )

    return run_logged(tasks, pass_on, jobs=jobs, progress=progress)
