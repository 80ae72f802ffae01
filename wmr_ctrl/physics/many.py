"""Figures of many runs on the rigid body, and their table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.physics.rigid import mujoco
from wmr_ctrl.physics.run import run_to_end
from wmr_ctrl.physics.workers import Progress, make_each
from wmr_ctrl.results import Run, tracked
from wmr_ctrl.results.figures import FIGURES, RIGID, SUMMED, values_of
from wmr_ctrl.results.outcomes import STOP_REASONS
from wmr_ctrl.scenario import Scenario, override
from wmr_ctrl.sim.figures import SHAPES
from wmr_ctrl.sim.many import RunTable, later, not_summed, planned_tasks
from wmr_ctrl.sim.runnable import RunnableLoop

Row: TypeAlias = dict[str, NDArray[np.generic]]
"""Figures of one run by name, each of its shape."""


def run_rigid_many(
    build: Callable[[Scenario], RunnableLoop],
    scenarios: Sequence[Scenario],
    seeds: Sequence[int],
    *,
    starts: Sequence[Sequence[float]] | None = None,
    figures: Sequence[str] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
) -> RunTable:
    """Figures of one run per seed, as `wmr_ctrl.sim.many.run_many` of the plane model.

    ``build``: from a scenario to its loop without a plant; ``jobs``: processes.  Errors as in
    `run_many` and `run_rigid`.
    """
    mujoco()
    tasks = planned_tasks(build, scenarios, seeds, starts, progress)
    pairs = [
        (task.loop if task.start is None else build(_started(task.loop.scenario, task.start)),
         task.seed)
        for task in tasks
    ]  # fmt: skip
    return rigid_table(pairs, figures, jobs, later(progress))


def rigid_table(
    runs: Sequence[tuple[RunnableLoop, int]],
    figures: Sequence[str] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
) -> RunTable:
    """The table of some runs, each made once for all of its figures."""
    whole = not_summed(figures)
    rows = make_each(partial(rigid_figures, further=whole), runs, jobs, progress)
    table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return RunTable({**table, "seed": np.array([seed for _, seed in runs])}, whole)


def _started(scenario: Scenario, start: tuple[float, ...]) -> Scenario:
    """The scenario from another state."""
    return override(scenario, {"initial.pose": start[:3], "initial.velocity": start[3:]})


def rigid_figures(loop: RunnableLoop, seed: int, further: Sequence[str] = ()) -> Row:
    """Figures, outcome and ``tracked`` of a run; it counts as stopped where it has tipped.

    ``further``: names of figures of the catalogue that are taken besides.
    """
    run, end = run_to_end(loop, seed)
    taken = values_of(run, map(FIGURES.__getitem__, further))
    row = {name: np.array(np.nan if value is None else value) for name, value in taken.items()}
    return {**figures_from_run(run, end), **_judged(run), **row}


@np.errstate(over="ignore", invalid="ignore")
def figures_from_run(run: Run, end: tuple[float, ...]) -> Row:
    """Every figure of `SHAPES` of one run, of its body too; ``end`` is its last state, (5,).

    They are those of `sim.many.run_many` but for the rounding of sums.
    """
    seen = run.monitor
    row = {name: np.full(shape, np.nan) for name, shape in SHAPES.items()}
    for figure in (*SUMMED, *(RIGID if seen.rigid else ())):
        value = figure.of(run)
        row.setdefault(figure.array, np.array(np.nan))[figure.index] = (
            np.nan if value is None else value
        )
    events = {"first": seen.first_violation, "stop": seen.stopped, "bounds": seen.bounds_left}
    row |= {
        f"{name}_axis": np.array(np.nan if e is None else float(e[1])) for name, e in events.items()
    }
    stop = np.array(float(STOP_REASONS.index(seen.stop_reason)))
    return row | {"final_state": np.array(end), "samples": np.array(float(run.rows)), "stop": stop}


def _judged(run: Run) -> Row:
    return {"outcome": np.array(run.outcome.value), "tracked": np.array(bool(tracked(run)))}
