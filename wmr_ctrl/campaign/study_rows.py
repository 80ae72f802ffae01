"""Outcome and figures of some runs of a study: what a worker is sent, and what it gives back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from wmr_ctrl.campaign.engine import PlannedCase, Refusal, Silent, built_loops
from wmr_ctrl.campaign.table import REFUSED
from wmr_ctrl.results import outcome_of
from wmr_ctrl.results.figures import RIGID, SHARES, SUMMED
from wmr_ctrl.sim.batch import Task, run_tasks
from wmr_ctrl.sim.figures import SHAPES, column_of, monitor, tracked
from wmr_ctrl.sim.many import logged_figures
from wmr_ctrl.sim.runnable import RunnableLoop

MOST_LOOPS = 16
"""Loops that are sent with a chunk; a worker makes more by itself, beside the others."""
Columns: TypeAlias = dict[str, np.ndarray]
Runs: TypeAlias = Sequence[tuple[RunnableLoop, int]]


@dataclass(frozen=True)
class StudyChunk:
    """Some runs of a study, and the figures that are asked of them: what a worker is sent.

    ``loops``: that of each run, where the worker need not build them.
    """

    runs: tuple[tuple[PlannedCase, int], ...]
    figures: tuple[str, ...]
    loops: tuple[RunnableLoop | Refusal, ...] = ()

    def with_loops(self) -> StudyChunk:
        """The same with its loops; as it is where almost every run has a case of its own."""
        cases = [case for case, _ in self.runs]
        if len(set(map(id, cases))) > MOST_LOOPS:
            return self
        return replace(self, loops=tuple(built_loops(cases, Silent(), "")))


def chunk_rows(chunk: StudyChunk, jobs: int | None) -> Columns:
    """Outcome, a guard's refusal and figures of each run of a chunk; a refused one has none.

    On ``jobs`` threads, or processes for the rigid body; what an executor's worker calls.
    """
    cases = (case for case, _ in chunk.runs)
    loops = chunk.loops or built_loops(cases, Silent(), "")
    places = [place for place, loop in enumerate(loops) if not isinstance(loop, Refusal)]
    seeds = [seed for _, seed in chunk.runs]
    ready = [
        (loop, seed)
        for loop, seed in zip(loops, seeds, strict=True)
        if not isinstance(loop, Refusal)
    ]
    rows: Columns = {name: np.full(len(loops), np.nan) for name in chunk.figures}
    outcome = [REFUSED] * len(loops)
    refusal = [loop.text if isinstance(loop, Refusal) else "" for loop in loops]
    if ready:
        take = _take_in_lanes if chunk.runs[0][0].plant == "ode" else _take_on_tyres
        taken = take(ready, chunk.figures, jobs)
        for place, text in zip(places, taken["outcome"], strict=True):
            outcome[place] = str(text)
        for name in chunk.figures:
            rows[name][places] = taken[name]
    return {"outcome": np.array(outcome), "refusal": np.array(refusal), **rows}


def _take_in_lanes(ready: Runs, names: Sequence[str], jobs: int | None) -> Columns:
    """On the plane model: figures that the loop adds up by itself; others by whole runs."""
    tasks = [Task(loop, seed) for loop, seed in ready]
    figures = run_tasks(tasks, jobs=jobs)
    guarded = np.array([loop.scenario.guard.enabled for loop, _ in ready])
    figures["guard_share"][~guarded] = 0.0
    outcome = [
        outcome_of(monitor({name: figures[name][k] for name in SHAPES}), bool(guarded[k])).value
        for k in range(len(ready))
    ]
    judged = tracked(figures, [loop.settings for loop, _ in ready])
    columns = _columns(figures, judged, np.array(outcome))
    whole = [name for name in names if name not in columns]
    return columns | (logged_figures(tasks, whole, jobs) if whole else {})


def _take_on_tyres(ready: Runs, names: Sequence[str], jobs: int | None) -> Columns:
    """On the rigid body: all figures from whole runs, each made once."""
    from wmr_ctrl.physics.many import rigid_figures
    from wmr_ctrl.physics.workers import make_each

    summed = {*SHARES, *(figure.name for figure in (*SUMMED, *RIGID))}
    whole = [name for name in names if name not in summed]
    rows = make_each(partial(rigid_figures, further=whole), ready, jobs)
    figures = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    further = {name: figures[name] for name in whole}
    return _columns(figures, figures["tracked"], figures["outcome"]) | further


def _columns(
    figures: Mapping[str, np.ndarray], tracked: np.ndarray, outcome: np.ndarray
) -> Columns:
    """One array a column: numbers, shares and outcome."""
    known = [figure for figure in (*SUMMED, *RIGID) if figure.array in figures]
    columns: Columns = {figure.name: column_of(figure, figures) for figure in known}
    shares = {"violated": columns["violations"] > 0, "tracked": tracked}
    columns |= {name: share.astype(float) for name, share in shares.items()}
    return columns | {"outcome": outcome}
