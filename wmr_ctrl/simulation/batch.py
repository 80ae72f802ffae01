"""Many runs at once: lanes of one library, batches of lanes, threads over batches.

A `Task` is one run.  Tasks of one structure (library, clock, phases, delay) share
batches; everything that is a number differs from lane to lane.  Figures are added up in C, so that
a run costs no memory; `run_logged` keeps the columns of a batch for as long as they are read.
"""

import ctypes as ct
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from typing import TypeVar

from wmr_ctrl.core.errors import ArgumentError, show
from wmr_ctrl.core.fields.values import MOST_JOBS
from wmr_ctrl.results import Floats, Monitor
from wmr_ctrl.results.windows import windows_of

from .figures import Figures, empty_figures, monitors, put
from .gpu import LAUNCHES, is_for_gpu, launched, robots_of
from .memory import Results, Task, laid_out, vector_set

Progress = Callable[[float], None]
T = TypeVar("T")


def run_tasks(
    tasks: Sequence[Task], *, jobs: int | None = None, progress: Progress | None = None
) -> Figures:
    """Figures of all tasks, in their order, each as an array over the tasks.

    ``jobs``: threads, by default one per processor; results do not depend on it.  ``progress`` is
    called with the share done.  Ctrl-C ends all batches within a sample and raises
    KeyboardInterrupt.  Raises CompilerError if a library does not fit, UnknownNameError for
    vectors that this processor lacks, ArgumentError for jobs < 1.
    """
    figures = empty_figures(len(tasks))

    def read(places: list[int], memory: Results) -> None:
        put(figures, places, memory, [tasks[k] for k in places])

    _run_batches(tasks, read, False, jobs, progress)
    return figures


def run_logged(
    tasks: Sequence[Task],
    then: Callable[[int, Floats, Monitor], T],
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> list[T]:
    """``then(place, rows of the log, monitor)`` of each task, in their order.

    ``then`` is called in the threads; rows that it does not keep are freed before the next batch.
    Otherwise as `run_tasks`.
    """
    results: dict[int, T] = {}

    def read(places: list[int], memory: Results) -> None:
        watched = monitors(memory, tasks[places[0]].loop.settings)
        for lane, place in enumerate(places):
            results[place] = then(place, memory.logged(lane), watched[lane])

    _run_batches(tasks, read, True, jobs, progress)
    return [results[place] for place in range(len(tasks))]


def check_jobs(jobs: int | None) -> None:
    """Raise ArgumentError unless ``jobs`` is None or a valid number of threads or processes."""
    if jobs is not None and not 1 <= jobs <= MOST_JOBS:
        raise ArgumentError(
            f"jobs = {show(jobs)} must be a whole number from 1 to {MOST_JOBS}, or left out "
            "for one per core."
        )


def cores() -> int:
    """Number of cores that this process may use, at least 1."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) or 1
    return os.cpu_count() or 1


def _batches(tasks: Sequence[Task], log: bool) -> list[list[int]]:
    """Indices of the tasks, in groups that fit a library's lanes and share a structure."""
    alike: dict[tuple[int, str | None], list[int]] = {}
    for place, task in enumerate(tasks):
        alike.setdefault((id(task.loop), task.vectors), []).append(place)
    groups: dict[tuple[object, ...], list[int]] = {}
    for same in alike.values():
        task = tasks[same[0]]
        compiled, windows = task.loop.compiled, windows_of(task.loop.settings)
        structure = compiled.library, compiled.structure, compiled.phase_start, compiled.delay_steps
        timed = task.loop.scenario.clock, tuple(windows.values()), task.vectors
        groups.setdefault((*structure, *timed), []).extend(same)
    batches = []
    for places in groups.values():
        task = tasks[places[0]]
        if is_for_gpu(task):
            lanes = robots_of(task, len(windows_of(task.loop.settings)), log=log)
        else:
            lanes = vector_set(task.loop.compiled.library, task.vectors).lanes
        batches += [places[k : k + lanes] for k in range(0, len(places), lanes)]
    return batches


def _made(chosen: Sequence[Task], log: bool, cancelled: ct.c_int32) -> Results | None:
    """Results of one batch; None if it was cancelled."""
    windows = [] if log else list(windows_of(chosen[0].loop.settings).values())
    if is_for_gpu(chosen[0]):
        return launched(chosen, windows, log, cancelled)
    memory = laid_out(chosen, windows, log=log, cancelled=cancelled)
    return memory if memory.run() else None


def _run_batches(
    tasks: Sequence[Task],
    read: Callable[[list[int], Results], None],
    log: bool,
    jobs: int | None,
    progress: Progress | None,
) -> None:
    """Run all batches on a few threads, calling ``read`` there; returns when all have ended."""
    check_jobs(jobs)
    cancelled, done = ct.c_int32(0), 0

    def one(places: list[int]) -> int:
        memory = _made([tasks[k] for k in places], log, cancelled)
        if memory:
            read(places, memory)
        return len(places)

    threads = jobs or cores()
    if any(map(is_for_gpu, tasks[:1])):
        threads = min(threads, LAUNCHES)
    for count in _finished(one, _batches(tasks, log), cancelled, threads):
        done += count
        if progress:
            progress(done / len(tasks))


def _finished(
    one: Callable[[list[int]], int], batches: Iterable[list[int]], cancelled: ct.c_int32, jobs: int
) -> Iterable[int]:
    """Sizes of the batches as they end; an error or an interrupt cancels the others."""
    with ThreadPoolExecutor(jobs, thread_name_prefix="lanes") as pool:
        try:
            left = iter(batches)
            waiting: set[Future[int]] = set()
            while True:
                waiting |= {pool.submit(one, k) for k in islice(left, 4 * jobs - len(waiting))}
                if not waiting:
                    break
                ready, waiting = wait(waiting, timeout=0.2, return_when=FIRST_COMPLETED)
                yield from (item.result() for item in ready)
        except BaseException:
            cancelled.value = 1
            pool.shutdown(wait=True, cancel_futures=True)
            raise


@contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """Context in which Ctrl-C does not reach newly started processes; it is delayed here.

    A terminal sends it to all processes, and the workers would end with tracebacks of their own
    before they are closed.  Windows has no such mask.
    """
    if os.name == "nt":
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # which would clear the mask when the first process starts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
