"""Outcome and figures of some runs of a study: what a worker is sent, and what it gives back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from wmr_ctrl.campaign.engine import Refusal, Silent, built_loops
from wmr_ctrl.campaign.plan import PlannedCase
from wmr_ctrl.campaign.table import REFUSED
from wmr_ctrl.results.figures import SHARES
from wmr_ctrl.sim.many import RunTable, tabulated
from wmr_ctrl.sim.memory import Task
from wmr_ctrl.sim.runnable import RunnableLoop

MOST_LOOPS = 16
"""Loops that are sent with a chunk; a worker makes more by itself, beside the others."""
Columns: TypeAlias = dict[str, np.ndarray]


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
        table = _table(ready, chunk.runs[0][0].plant, chunk.figures, jobs)
        for place, text in zip(places, table["outcome"], strict=True):
            outcome[place] = str(text)
        columns = {"violated": table["violations"] > 0, **table.columns()}
        for name in chunk.figures:
            rows[name][places] = columns[name]
    return {"outcome": np.array(outcome), "refusal": np.array(refusal), **rows}


def _table(
    ready: Sequence[tuple[RunnableLoop, int]], plant: str, names: Sequence[str], jobs: int | None
) -> RunTable:
    """The table of loops and seeds on that plant, with the figures that are not shares of runs."""
    further = [name for name in names if name not in SHARES]
    if plant == "mujoco":
        from wmr_ctrl.physics.run import rigid_table

        return rigid_table(ready, further, jobs)
    return tabulated([Task(loop, seed) for loop, seed in ready], further, jobs)
