"""Many runs side by side: as one table of arrays, or each a whole Run."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, SupportsIndex, TypeVar

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fields.arguments import checks_arguments
from wmr_ctrl.fields.limits import MOST_SEEDS, SEED_END
from wmr_ctrl.fields.problems import show
from wmr_ctrl.results import Monitor, Run, split_columns
from wmr_ctrl.results.figures import FIGURES, RIGID, SUMMED, values_of
from wmr_ctrl.results.frames import figure, table_frame, table_html
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.batch import Floats, Progress, run_logged, run_tasks
from wmr_ctrl.sim.figures import column_of
from wmr_ctrl.sim.memory import Task
from wmr_ctrl.sim.runnable import RunnableLoop, assemble_run

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, repr=False)
class RunTable(Mapping[str, NDArray[np.float64]]):
    """Figures of many runs: an array by name, one row a run, in the order in which they were asked.

    Names and units are those of `sim.figures.SHAPES`, on the rigid body those of
    `results.figures.RIGID` too, and of the ``further`` figures that were asked for; ``outcome``
    (str), ``seed`` and ``tracked`` (bool, RMS of drive and end against metrics.tolerance) besides.
    A run's remarks need its whole log: `wmr_ctrl.simulate_runs`.
    """

    figures: Mapping[str, NDArray[np.float64]]
    further: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<RunTable, {self.rows} runs, {len(self)} figures>"

    def _repr_html_(self) -> str:
        """The first runs and their main figures, for notebooks."""
        columns = self.columns()
        names = [name for name in SHOWN if name in columns]
        units = {f.name: f.unit for f in FIGURES if f.name not in HEADS}
        heads = [f"{name} [{units[name]}]" if name in units else name for name in names]
        rows = [
            [figure(columns[name][k].item()) for name in names] for k in range(min(self.rows, 8))
        ]
        return table_html(f"{self.rows} runs", rows, heads)

    @property
    def rows(self) -> int:
        """Number of runs."""
        return len(self.figures["seed"])

    def columns(self) -> dict[str, NDArray[np.generic]]:
        """One array of numbers a column, by the names that study tables have."""
        heads: dict[str, NDArray[np.generic]] = {name: self.figures[name] for name in HEADS}
        summed = [figure for figure in (*SUMMED, *RIGID) if figure.array in self.figures]
        taken = {figure.name: column_of(figure, self.figures) for figure in summed}
        return heads | taken | {name: self.figures[name] for name in self.further}

    @checks_arguments
    def to_dataframe(self) -> pandas.DataFrame:
        """One row a run, one number a column; units in ``attrs``.  Raises MissingExtraError."""
        return table_frame(self.columns(), {figure.name: figure.unit for figure in FIGURES})

    @checks_arguments
    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self.figures:
            raise UnknownNameError("figure", name, self.figures)
        return self.figures[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.figures)

    def __len__(self) -> int:
        return len(self.figures)


def run_many(
    build: Callable[[Scenario], RunnableLoop],
    scenarios: Sequence[Scenario],
    seeds: Sequence[int],
    *,
    starts: Sequence[Sequence[float]] | None = None,
    figures: Sequence[str] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
) -> RunTable:
    """Figures of one run per seed.

    ``build`` gives the compiled loop of a scenario, once for each different one; ``scenarios`` and
    ``starts`` (x, y [m], theta [rad], v1 [m/s], omega [rad/s] at t = 0; None: the scenario's) are
    one a run, or one scenario for all; ``figures``: names of further figures of the catalogue, for
    which all is run once more where they need a log.  Otherwise as `sim.batch.run_tasks`.
    Raises ArgumentError if the numbers of them do not fit, or there is no run.
    """
    tasks = planned_tasks(build, scenarios, seeds, starts, progress)
    return tabulated(tasks, figures, jobs, later(progress))


def tabulated(
    tasks: Sequence[Task],
    figures: Sequence[str] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
) -> RunTable:
    """The table of some runs; ``figures`` that need a log are taken from runs made once more."""
    whole = not_summed(figures)
    arrays = run_tasks(tasks, jobs=jobs, progress=progress)
    arrays["seed"] = np.array([task.seed for task in tasks])
    if whole:
        chosen = [FIGURES[name] for name in whole]
        rows = each_task(tasks, lambda _, run: list(values_of(run, chosen).values()), jobs)
        arrays |= dict(zip(whole, np.array(rows, dtype=float).T, strict=True))
    return RunTable(arrays, whole)


def planned_tasks(
    build: Callable[[Scenario], RunnableLoop],
    scenarios: Sequence[Scenario],
    seeds: Sequence[int],
    starts: Sequence[Sequence[float]] | None,
    progress: Progress | None,
) -> list[Task]:
    """A task a seed, of loops that are built once for each different scenario; as `run_many`."""
    count = len(seeds)
    if count == 0:
        raise ArgumentError("seeds is empty: name at least one.")
    if len(scenarios) not in (1, count):
        raise ArgumentError(
            f"overrides has {len(scenarios)} entries for {count} seeds; give one for all runs, or "
            "one a seed."
        )
    if starts is not None and (len(starts) != count or any(len(row) != 5 for row in starts)):
        raise ArgumentError(f"starts must have the shape ({count}, 5), a row a seed.")
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
"""Share of the progress that is told while loops are compiled and filled with numbers."""


def later(progress: Progress | None) -> Progress | None:
    """Progress of the runs, behind what was told before."""
    return progress and (lambda share: progress(PREPARING + (1.0 - PREPARING) * share))


HEADS = ("seed", "outcome", "tracked")
SHOWN = (*HEADS, "position_rms", "ise_total", "max_abs_v1", "max_abs_v2")
"""Columns that notebooks show."""


T = TypeVar("T")


def run_each(
    runs: Sequence[tuple[RunnableLoop, int]],
    then: Callable[[int, Run], T],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[T]:
    """``then(place, run)`` of each pair (loop, seed), in their order.

    Several robots run at a time on each of ``jobs`` threads (default: one per core), in which
    ``then`` is called too; results do not depend on the number.  ``progress`` is called with the
    share done.  Ctrl-C ends all threads within a sample.  Raises CompilerError.
    """
    return each_task([Task(item, seed) for item, seed in runs], then, jobs, progress)


def each_task(
    tasks: Sequence[Task],
    then: Callable[[int, Run], T],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
    engine: str = "lanes",
) -> list[T]:
    """`run_each` for tasks; ``engine``: what made the runs."""

    def pass_on(place: int, rows: Floats, watched: Monitor) -> T:
        item, seed = tasks[place].loop, tasks[place].seed
        signals, facts = item.compiled.layout.columns, {"kernel_hash": item.compiled.digest}
        log = signals, split_columns(signals, rows), watched
        run = assemble_run(item.scenario, item.law, seed, engine, log, facts, item.bounds)
        return then(place, run)

    return run_logged(tasks, pass_on, jobs=jobs, progress=progress)


def not_summed(names: Sequence[str]) -> tuple[str, ...]:
    """Those of the figures' names that need a whole log.  Raises UnknownNameError."""
    return tuple(name for name in dict.fromkeys(names) if not FIGURES[name].array)


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


def checked_starts(starts: Iterable[Iterable[float]]) -> list[tuple[float, ...]]:
    """States at t = 0 as rows of numbers; raises ArgumentError for what is none."""
    try:
        return [tuple(map(float, row)) for row in starts]
    except (TypeError, ValueError):
        raise ArgumentError(
            "starts must hold five numbers a run: x, y [m], theta [rad], v1 [m/s], omega [rad/s]."
        ) from None
