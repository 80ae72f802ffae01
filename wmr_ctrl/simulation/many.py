"""Many runs side by side: as one table of arrays, or each a whole Run."""

import operator
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import SupportsIndex, TypeVar

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, show
from wmr_ctrl.core.fields.orientation import inward
from wmr_ctrl.core.fields.values import MOST_SEEDS, SEED_END
from wmr_ctrl.results import Monitor, Run, RunTable, split_columns, table_of_rows
from wmr_ctrl.results.figures import FIGURES, RIGID, SUMMED, values_of
from wmr_ctrl.world.scenario import Scenario

from .batch import Floats, Progress, run_logged, run_tasks
from .gpu import is_for_gpu
from .memory import Task
from .runnable import RunnableLoop, assemble_run


def tabulated(
    tasks: Sequence[Task],
    figures: Sequence[str] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
) -> RunTable:
    """The table of some runs, made as by `sim.batch.run_tasks`.

    ``figures``: names of further figures of the catalogue; those that need a log come from a second
    run.
    """
    whole = not_summed(figures)
    seeds = np.array([task.seed for task in tasks])
    columns = {"seed": seeds, **run_tasks(tasks, jobs=jobs, progress=progress)}
    if whole:
        rows = each_task(
            tasks, lambda _, run: values_of(run, map(FIGURES.__getitem__, whole)), jobs
        )
        columns |= table_of_rows(rows).columns
    return RunTable(columns)


def planned_tasks(
    build: Callable[[Scenario], RunnableLoop],
    scenarios: Sequence[Scenario],
    seeds: Sequence[int],
    starts: Sequence[Sequence[float]] | None,
    progress: Progress | None,
) -> list[Task]:
    """One task per seed.

    ``build`` returns the compiled loop of a scenario, once for each different one; ``scenarios``
    and ``starts`` (x, y [m], theta [rad], v1 [m/s], omega [rad/s] at t = 0; None: the scenario's)
    are one per run, or one scenario for all.  Raises ArgumentError if their numbers do not match,
    or there is no run.
    """
    count = len(seeds)
    if count == 0:
        raise ArgumentError("seeds is empty: name at least one.")
    if len(scenarios) not in (1, count):
        raise ArgumentError(
            f"overrides has {len(scenarios)} entries for {count} seeds; give one for all runs, or "
            "one per seed."
        )
    if starts is not None and (len(starts) != count or any(len(row) != 5 for row in starts)):
        raise ArgumentError(f"starts must have the shape ({count}, 5), one row per seed.")
    listed = list(scenarios) * count if len(scenarios) == 1 else list(scenarios)
    different, loops = list(dict.fromkeys(listed)), dict[Scenario, RunnableLoop]()
    for k, scenario in enumerate(different):
        if progress and k % 16 == 0:
            progress(PREPARING * k / len(different))
        loops[scenario] = build(scenario)
    rows = [None] * count if starts is None else [tuple(map(float, row)) for row in starts]
    runs = zip(listed, seeds, rows, strict=True)
    return [Task(loops[scenario], int(seed), start) for scenario, seed, start in runs]


PREPARING = 0.1
"""Share of the progress shown while loops are compiled and filled with numbers."""


def part(progress: Progress | None, begin: float, end: float = 1.0) -> Progress | None:
    """Progress of one part of a job, between two shares of the whole."""
    return progress and (lambda share: progress(begin + (end - begin) * share))


T = TypeVar("T")


def run_each(
    runs: Sequence[tuple[RunnableLoop, int]],
    then: Callable[[int, Run], T],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[T]:
    """``then(place, run)`` of each pair (loop, seed), in their order.

    Several robots run at a time on each of ``jobs`` threads (default: one per core), which also
    call ``then``; results do not depend on the number. ``progress`` is called with the share done.
    Ctrl-C ends all threads within a sample. Raises CompilerError.
    """
    return each_task([Task(item, seed) for item, seed in runs], then, jobs, progress)


def each_task(
    tasks: Sequence[Task],
    then: Callable[[int, Run], T],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
    engine: str | None = None,
) -> list[T]:
    """`run_each` for tasks; ``engine``: the runs' maker, by default "lanes" or "gpu"."""

    def pass_on(place: int, rows: Floats, watched: Monitor) -> T:
        item, seed = tasks[place].loop, tasks[place].seed
        signals, facts = item.compiled.layout.columns, {"kernel_hash": item.compiled.digest}
        log = signals, split_columns(signals, rows), watched
        made_by = engine or ("gpu" if is_for_gpu(tasks[place]) else "lanes")
        run = assemble_run(item.scenario, item.law, seed, made_by, log, facts, item.bounds)
        return then(place, run)

    return run_logged(tasks, pass_on, jobs=jobs, progress=progress)


def not_summed(names: Sequence[str]) -> tuple[str, ...]:
    """Names of the figures that need a whole log.  Raises UnknownNameError."""
    return tuple(name for name in dict.fromkeys(names) if FIGURES[name] not in (*SUMMED, *RIGID))


def checked_seeds(seeds: Iterable[int]) -> list[int]:
    """The seeds; raises ArgumentError unless they are `MOST_SEEDS` whole numbers below SEED_END."""
    listed = list(islice(seeds, MOST_SEEDS + 1))
    if len(listed) > MOST_SEEDS:
        raise ArgumentError(f"there are more than {MOST_SEEDS} seeds. Give them in parts.")
    if not listed:
        raise ArgumentError("seeds: there must be at least one.")
    for seed in listed:
        whole = isinstance(seed, SupportsIndex) and not isinstance(seed, bool)
        if not (whole and 0 <= operator.index(seed) < SEED_END):
            raise ArgumentError(
                f"seed = {show(seed)} must be a whole number from 0 up, below {SEED_END}."
            )
    return listed


def checked_starts(
    starts: Iterable[Iterable[float]], scenarios: Sequence[Scenario]
) -> list[tuple[float, ...]]:
    """States at t = 0 as rows of numbers, theta from +Y; they are given in the scenarios' frames.

    Raises ArgumentError for values that are not rows of numbers.
    """
    try:
        rows = [tuple(map(float, row)) for row in starts]
    except (TypeError, ValueError):
        raise ArgumentError(
            "starts must hold five numbers per run: x, y [m], theta [rad], v1 [m/s], omega [rad/s]."
        ) from None
    each = list(scenarios) * (len(rows) if len(scenarios) == 1 else 1)
    if len(each) != len(rows):
        return rows  # which is refused where they meet the seeds
    return [
        (*row[:2], *(inward(theta, item.frames) for theta in row[2:3]), *row[3:])
        for row, item in zip(rows, each, strict=True)
    ]
