"""Runs in processes of their own: MuJoCo's steps and Python's between them want a core each.

Unlike those of `multiprocessing` the processes do not import the user's script once more, so that
many runs may stand at its top level.
"""

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue
from typing import TypeAlias, TypeVar

from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.simulation.batch import Progress, check_jobs, cores
from wmr_ctrl.simulation.runnable import RunnableLoop

from .rigid import mujoco

T = TypeVar("T")
_BEGIN = f"from {__name__} import serve; serve()"
_ROOT = str(Path(__file__).parents[3])
ResultsOf: TypeAlias = Callable[[Sequence[tuple[RunnableLoop, int]]], Iterator[T]]


def make_each(
    make: Callable[[RunnableLoop, int], T],
    runs: Sequence[tuple[RunnableLoop, int]],
    jobs: int | None = None,
    progress: Progress | None = None,
) -> list[T]:
    """Results of ``make`` for each pair (loop, seed), in their order.

    On ``jobs`` processes (default: one per core), or here for one; ``make`` must be importable by
    its name.  The result is the same for any ``jobs``.  ``progress`` is called with the share done.
    Ctrl-C ends all processes.  Raises what ``make`` raises, MissingExtraError, and ArgumentError
    for jobs < 1.
    """
    check_jobs(jobs)
    mujoco()
    results = list[T]()
    with _makers(make, min(jobs or cores(), len(runs))) as results_of:
        for result in results_of(runs):
            results.append(result)
            if progress is not None:
                progress(len(results) / len(runs))
    return results


@contextmanager
def _makers(make: Callable[[RunnableLoop, int], T], count: int) -> Iterator[ResultsOf[T]]:
    """Results of runs that are made here or by several processes; none is left at the end."""
    if count <= 1:
        yield lambda runs: (make(loop, seed) for loop, seed in runs)
        return
    workers = [Worker() for _ in range(count)]
    free: SimpleQueue[Worker] = SimpleQueue()
    for worker in workers:
        free.put(worker)

    def one(run: tuple[RunnableLoop, int]) -> T:
        worker = free.get()
        try:
            return worker.ask(make, run)
        finally:
            free.put(worker)

    with ThreadPoolExecutor(count) as pool:
        try:
            yield lambda runs: pool.map(one, runs)
        finally:
            for worker in workers:
                worker.end()
            pool.shutdown(cancel_futures=True)


class Worker:
    """A process that makes calls for another one, one after the other."""

    def __init__(self, environment: Mapping[str, str] | None = None) -> None:
        """Start it, without waiting for it; ``environment``: variables that it is given besides."""
        paths = filter(None, (_ROOT, os.environ.get("PYTHONPATH")))
        own = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **(environment or {})}
        self._process = subprocess.Popen(
            [sys.executable, "-c", _BEGIN], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=own
        )

    def ask(self, make: Callable[..., T], given: tuple[object, ...]) -> T:
        """``make(*given)``; raises what it raised there, WmrError if the process ended.

        ``make`` must be importable by its name.
        """
        try:
            assert self._process.stdin is not None
            assert self._process.stdout is not None
            pickle.dump((make, given), self._process.stdin)
            self._process.stdin.flush()
            result, error = pickle.load(self._process.stdout)
        except (EOFError, OSError):
            raise WmrError(
                "a process that worked on the rigid body ended before its result. Was it killed, "
                "or was the memory full? Use fewer jobs, or jobs=1, which needs no process for a "
                "run."
            ) from None
        if error is not None:
            raise error
        answer: T = result
        return answer

    def end(self) -> None:
        """End it, whatever it does."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()


def serve() -> None:
    """Worker main loop: answer each call until the input ends.

    What is printed meanwhile goes to stderr; Ctrl-C is left to the process that asked.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        while True:
            try:
                make, given = pickle.load(sys.stdin.buffer)
            except EOFError:
                return
            answer: tuple[object, Exception | None]
            try:
                answer = make(*given), None
            except Exception as error:
                answer = None, error
            pickle.dump(answer, answers)
            answers.flush()
