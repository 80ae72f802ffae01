"""Outcome and figures of some runs of a study: what a worker is sent, and what it gives back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from wmr_ctrl.campaign.engine import PlannedCase, Refusal, Silent, built_loops
from wmr_ctrl.campaign.figures import figure_named
from wmr_ctrl.campaign.study_plan import SHARES
from wmr_ctrl.results import Run, outcome_of
from wmr_ctrl.sim.batch import Task, run_tasks
from wmr_ctrl.sim.figures import COLUMNS, RIGID_COLUMNS, SHAPES, column_of, monitor, tracked
from wmr_ctrl.sim.many import run_each
from wmr_ctrl.sim.ready import Ready

REFUSED = "refused"
MOST_LOOPS = 16
"""Loops that are sent with a chunk; a worker makes more by itself, beside the others."""
Columns: TypeAlias = dict[str, np.ndarray]
Runs: TypeAlias = Sequence[tuple[Ready, int]]


@dataclass(frozen=True)
class StudyChunk:
    """Some runs of a study, and the figures that are asked of them: what a worker is sent.

    ``loops``: that of each run, where the worker need not build them.
    """

    runs: tuple[tuple[PlannedCase, int], ...]
    figures: tuple[str, ...]
    loops: tuple[Ready | Refusal, ...] = ()

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
    columns = _sums(ready, jobs)
    whole = [name for name in names if name not in columns]
    return columns | (_logged(ready, whole, jobs) if whole else {})


def _take_on_tyres(ready: Runs, names: Sequence[str], jobs: int | None) -> Columns:
    """On the rigid body: all figures from whole runs, each made once."""
    from wmr_ctrl.physics.many import rigid_rows

    summed = {*SHARES, *(column.name for column in (*COLUMNS, *RIGID_COLUMNS))}
    whole = [name for name in names if name not in summed]
    pairs = rigid_rows(ready, partial(_figures_of, whole), jobs)
    figures = {name: np.array([row[name] for row, _ in pairs]) for name in pairs[0][0]}
    further = dict(zip(whole, np.array([values for _, values in pairs]).T, strict=True))
    return _columns(figures, figures["tracked"], figures["outcome"]) | further


def _sums(ready: Runs, jobs: int | None) -> Columns:
    """Figures that the loop adds up by itself."""
    figures = run_tasks([Task(loop, seed) for loop, seed in ready], jobs=jobs)
    guarded = np.array([loop.scenario.guard.enabled for loop, _ in ready])
    figures["guard_share"][~guarded] = 0.0
    outcome = [
        outcome_of(monitor({name: figures[name][k] for name in SHAPES}), bool(guarded[k])).value
        for k in range(len(ready))
    ]
    judged = tracked(figures, [loop.settings for loop, _ in ready])
    return _columns(figures, judged, np.array(outcome))


def _columns(
    figures: Mapping[str, np.ndarray], tracked: np.ndarray, outcome: np.ndarray
) -> Columns:
    """One array a column: numbers, shares and outcome."""
    known = [c for c in (*COLUMNS, *RIGID_COLUMNS) if c.figure in figures]
    columns: Columns = {column.name: column_of(column, figures) for column in known}
    shares = (columns["violations"] > 0, tracked)
    columns |= {name: share.astype(float) for name, share in zip(SHARES, shares, strict=True)}
    return columns | {"outcome": outcome}


def _logged(ready: Runs, names: Sequence[str], jobs: int | None) -> Columns:
    """Figures that need a whole log, from runs made once more."""
    table = np.array(run_each(ready, lambda _, run: _figures_of(names, run), jobs), dtype=float)
    return dict(zip(names, table.T, strict=True))


def _figures_of(names: Sequence[str], run: Run) -> list[float]:
    values = [figure_named(name).of(run) for name in names]
    return [np.nan if value is None else float(value) for value in values]
