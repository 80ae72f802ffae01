"""Figures of many runs on the rigid body, and their table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.physics.rigid import mujoco
from wmr_ctrl.physics.run import run_to_end
from wmr_ctrl.physics.workers import Progress, make_each
from wmr_ctrl.results import Run, tracked
from wmr_ctrl.scenario import Scenario, override
from wmr_ctrl.sim.figures import RIGID_COLUMNS
from wmr_ctrl.sim.many import RunTable, later, planned_tasks
from wmr_ctrl.sim.ready import Ready
from wmr_ctrl.sim.taken import figures_taken

Row: TypeAlias = dict[str, NDArray[np.generic]]
"""Figures of one run by name, each of its shape."""
T = TypeVar("T")


def run_rigid_many(
    build: Callable[[Scenario], Ready],
    scenarios: Sequence[Scenario],
    seeds: Sequence[int],
    *,
    starts: Sequence[Sequence[float]] | None = None,
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
    rows = make_each(rigid_figures, pairs, jobs, later(progress))
    table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return RunTable({**table, "seed": np.array(seeds)})


def _started(scenario: Scenario, start: tuple[float, ...]) -> Scenario:
    """The scenario from another state."""
    return override(scenario, {"initial.pose": start[:3], "initial.velocity": start[3:]})


def rigid_figures(loop: Ready, seed: int) -> Row:
    """Figures, outcome and ``tracked`` of a run; it counts as stopped where it has tipped."""
    return rigid_figures_and(loop, seed, _nothing)[0]


def rigid_figures_and(loop: Ready, seed: int, then: Callable[[Run], T]) -> tuple[Row, T]:
    """The same, and what ``then`` makes of the whole Run."""
    run, end = run_to_end(loop, seed)
    return {**figures_taken(run, end), **_on_tyres(run), **_judged(run)}, then(run)


def rigid_rows(
    runs: Sequence[tuple[Ready, int]], then: Callable[[Run], T], jobs: int | None
) -> list[tuple[Row, T]]:
    """`rigid_figures_and` of each pair (loop, seed), in their order, on ``jobs`` processes."""
    return make_each(partial(rigid_figures_and, then=then), runs, jobs)


def _nothing(_: Run) -> None:
    """What is made of a Run whose figures suffice."""


def _on_tyres(run: Run) -> Row:
    """What the body showed; None becomes NaN."""
    assert run.monitor.rigid is not None
    seen = asdict(run.monitor.rigid)
    row: Row = {c.name: np.array(seen[c.figure], dtype=float) for c in RIGID_COLUMNS}
    return row | ({} if run.monitor.rigid.tipped is None else {"stopped": row["tipped"]})


def _judged(run: Run) -> Row:
    return {"outcome": np.array(run.outcome.value), "tracked": np.array(bool(tracked(run)))}
