"""Runs in separate processes: MuJoCo's steps and the Python between them need a core each.

Unlike those of `multiprocessing` the processes do not import the user's script again, so that many
runs may be at its top level.
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

    On ``jobs`` processes (default: one per core), or in this process for one; ``make`` must be
    importable by its name. The result is the same for any ``jobs``. ``progress`` is called with the
    share done. Ctrl-C ends all processes. Raises what ``make`` raises, MissingExtraError, and
    ArgumentError for jobs < 1.
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
    """Context that yields results of runs made here or by several processes, which end with it."""
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
    """A process that executes calls for another one, one after the other."""

    def __init__(self, environment: Mapping[str, str] | None = None) -> None:
        """Start the process without waiting for it; ``environment``: additional variables."""
        paths = filter(None, (_ROOT, os.environ.get("PYTHONPATH")))
        own = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **(environment or {})}
        self._process = subprocess.Popen(
            [sys.executable, "-c", _BEGIN], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=own
        )

    def ask(self, make: Callable[..., T], given: tuple[object, ...]) -> T:
        """Return ``make(*given)``; raises its error, or WmrError if the process ended.

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
        """End the process, whatever it is doing."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()


def serve() -> None:
    """Main loop of a worker: execute each call until the input ends.

    Its output goes to stderr; Ctrl-C is left to the calling process.
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
