"""The native engine: one run of the loop that is compiled for one robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.compiled import Signals
from wmr_ctrl.results import Monitor
from wmr_ctrl.sim.batch import Task
from wmr_ctrl.sim.figures import monitors
from wmr_ctrl.sim.memory import laid_out
from wmr_ctrl.sim.runnable import RunnableLoop

Floats = NDArray[np.float64]


def run_native(loop: RunnableLoop, seed: int) -> tuple[dict[str, Floats], Monitor]:
    """One run: columns by signal name, (N,) or (N, size), and the monitor.

    The call releases Python's lock, so threads run in parallel.
    """
    task = Task(loop, seed)
    memory = laid_out([task], [], log=True)
    memory.run()
    (watched,) = monitors(memory, [task])
    return split_columns(loop.compiled.layout.columns, memory.logged(0)), watched


def split_columns(signals: Signals, rows: Floats) -> dict[str, Floats]:
    """Rows of the log as one array per signal."""
    columns, at = {}, 0
    for signal in signals:
        part = rows[:, at : at + signal.size]
        columns[signal.name] = part[:, 0] if signal.size == 1 else part
        at += signal.size
    return columns
