"""Many runs at once: lanes of one library, batches of lanes, threads over batches.

A `Task` is one run.  Tasks of one structure (library, clock, phases, sensors, actuators) share
batches; everything that is a number differs from lane to lane.  Figures are added up in C, so that
a run costs no memory; its columns are logged only where `run_logged` asks for them.
"""

from __future__ import annotations

import ctypes as ct
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results import Monitor, Settings
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.batch_figures import Figures, empty_figures, monitors, put, windows_of
from wmr_ctrl.sim.batch_memory import Memory, laid_out, library_of
from wmr_ctrl.sim.native import Kernels, columns_of, split_columns

Floats = NDArray[np.float64]
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Task:
    """One run: its kernels (built for lanes), scenario, how it is read, seed, and start.

    ``start``: x, y [m], theta [rad], v1 [m/s], omega [rad/s]; None as the scenario has it.
    """

    kernels: Kernels
    scenario: Scenario
    settings: Settings
    seed: int
    start: tuple[float, ...] | None = None


def run_tasks(
    tasks: Sequence[Task], *, jobs: int | None = None, progress: Progress | None = None
) -> Figures:
    """Figures of all tasks, in their order, each as an array over the tasks.

    ``jobs``: threads, by default one per processor; results do not depend on it.  ``progress`` is
    called with the share done.  Ctrl-C ends all batches within a sample and raises
    KeyboardInterrupt.  Raises CompilerError if a library does not fit.
    """
    found = empty_figures(len(tasks))
    batches = _batches(tasks)
    done = 0
    for places, memory in _finished(batches, tasks, jobs):
        put(found, places, memory, [tasks[k] for k in places])
        done += len(places)
        if progress:
            progress(done / len(tasks))
    return found


def run_logged(tasks: Sequence[Task]) -> list[tuple[dict[str, Floats], Monitor]]:
    """Columns by signal name and monitor of each task, as `sim.native.run_native` gives them."""
    found: list[Any] = [None] * len(tasks)
    for places in _batches(tasks):
        chosen = [tasks[k] for k in places]
        memory = laid_out(chosen, windows_of(chosen[0].settings), log=True)
        _run(chosen[0].kernels, memory)
        signals = columns_of(chosen[0].kernels.manifest)
        for lane, (place, watched) in enumerate(zip(places, monitors(memory, chosen), strict=True)):
            rows = np.ascontiguousarray(memory.logged(lane))
            found[place] = split_columns(signals, rows), watched
    return found


def _batches(tasks: Sequence[Task]) -> list[list[int]]:
    """Places of the tasks, in groups that fit the lanes of their library and share a structure."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for place, task in enumerate(tasks):
        groups.setdefault(_structure(task), []).append(place)
    found = []
    for places in groups.values():
        lanes = library_of(tasks[places[0]].kernels.library).lanes
        found += [places[k : k + lanes] for k in range(0, len(places), lanes)]
    return found


def _structure(task: Task) -> tuple[object, ...]:
    """What the lanes of one batch have in common."""
    scenario, manifest = task.scenario, task.kernels.manifest
    steps = tuple(phase["step"] for phase in manifest["phases"])
    clock, actuator, sensor = scenario.clock, scenario.actuator, scenario.sensor
    pose = (sensor.perfect, None if sensor.perfect else sensor.pose_period)
    settings = (task.settings.split, task.settings.rms_from)
    return (task.kernels.library, clock, steps, pose, actuator.ideal, actuator.delay, settings)


def _finished(
    batches: Iterable[list[int]], tasks: Sequence[Task], jobs: int | None
) -> Iterable[tuple[list[int], Memory]]:
    """Batches as they finish, from a few threads; none is left running when this ends."""
    cancelled = ct.c_int32(0)

    def one(places: list[int]) -> tuple[list[int], Memory]:
        chosen = [tasks[k] for k in places]
        memory = laid_out(chosen, windows_of(chosen[0].settings), cancelled=cancelled)
        _run(chosen[0].kernels, memory)
        return places, memory

    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as pool:
        try:
            waiting: set[Future[tuple[list[int], Memory]]] = {pool.submit(one, k) for k in batches}
            while waiting:
                ready, waiting = wait(waiting, timeout=0.2, return_when=FIRST_COMPLETED)
                yield from (item.result() for item in ready)
        except BaseException:
            cancelled.value = 1
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _run(kernels: Kernels, memory: Memory) -> None:
    library_of(kernels.library).run(ct.byref(memory.settings))
