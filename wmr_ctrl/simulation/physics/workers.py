"""Runs in separate processes: MuJoCo's steps and the Python between them need a core each.

Unlike those of `multiprocessing`, loky's processes do not import the user's script again, so that
many runs may be at its top level.
"""

import signal
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from wmr_ctrl.core.errors import WmrError, library
from wmr_ctrl.simulation.batch import Progress, check_jobs, cores
from wmr_ctrl.simulation.runnable import RunnableLoop

from .rigid import mujoco

T = TypeVar("T")


def make_each(
    make: Callable[[RunnableLoop, int], T],
    runs: Sequence[tuple[RunnableLoop, int]],
    jobs: int | None = None,
    progress: Progress | None = None,
) -> list[T]:
    """Results of ``make`` for each pair (loop, seed), in their order.

    On ``jobs`` processes (default: one per core), or in this process for one. The result is the
    same for any ``jobs``. ``progress`` is called with the share done. Ctrl-C ends all processes.
    Raises what ``make`` raises, MissingExtraError, ArgumentError for jobs < 1, and WmrError if a
    process ended.
    """
    check_jobs(jobs)
    mujoco()
    results = list[T]()
    for result in _made(make, runs, min(jobs or cores(), len(runs))):
        results.append(result)
        if progress is not None:
            progress(len(results) / len(runs))
    return results


def _made(
    make: Callable[[RunnableLoop, int], T], runs: Sequence[tuple[RunnableLoop, int]], count: int
) -> Iterator[T]:
    """Results of runs made here or by several processes, which end with the last one."""
    if count <= 1:
        yield from (make(*run) for run in runs)
        return
    loky = library("loky", "physics")
    pool = loky.ProcessPoolExecutor(
        count, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN)
    )
    try:
        yield from pool.map(make, *zip(*runs, strict=True))
    except loky.process_executor.TerminatedWorkerError:
        raise WmrError(
            "a process that worked on the rigid body ended before its result. Was it killed, or "
            "was the memory full? Use fewer jobs, or jobs=1, which needs no process for a run."
        ) from None
    finally:
        pool.shutdown(kill_workers=True)
