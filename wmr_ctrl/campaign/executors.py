"""Where the chunks of a study run: threads here, any `concurrent.futures` executor, or Dask."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any, ParamSpec, TypeVar

from wmr_ctrl.campaign.study_rows import StudyChunk
from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.results.frames import library
from wmr_ctrl.sim.batch import cores

THREADS, DASK, SCHEME = "threads", "dask", "dask://"
PATIENCE = 20.0
"""Seconds within which a scheduler has to answer."""
QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "5s",
}
"""Half of Dask's own work in a process that only computes."""
RETRIES = 3
"""How often a chunk is sent again after its worker was lost."""

Facts = Mapping[str, str]
P = ParamSpec("P")
T = TypeVar("T")


@contextmanager
def executor_named(
    name: str | Executor,
    jobs: int | None,
    facts: Callable[[], Facts],
    asked: Callable[[], Facts],
) -> Iterator[Executor | None]:
    """The executor of that name, closed at the end; None for threads of this process.

    ``facts`` gives this process's versions; ``asked`` is what each worker is asked to compare.
    Processes of this machine use its libraries: they are sent loops.
    Raises UnknownNameError, MissingExtraError without distributed, ArgumentError for a scheduler
    that does not answer or a worker of another version.
    """
    if isinstance(name, Executor):
        yield name
    elif name == THREADS:
        yield None
    elif name == DASK:
        with _local(jobs) as executor:
            yield _SendsLoops(executor)
    elif name.startswith(SCHEME):
        distributed: Any = library("distributed", "cluster")
        with _client(distributed, f"tcp://{name.removeprefix(SCHEME)}", name) as client:
            _compare(client, facts(), asked)
            yield client.get_executor(pure=False, retries=RETRIES)
    else:
        raise UnknownNameError("executor", name, (THREADS, DASK, f"{SCHEME}HOST:PORT"))


class _SendsLoops(Executor):
    """An executor whose workers get the loops of a chunk, and so need no graphs of their own."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Send a call with its chunk."""
        sent: list[Any] = [
            item.with_loops() if isinstance(item, StudyChunk) else item for item in args
        ]
        return self._executor.submit(fn, *sent, **kwargs)


@contextmanager
def _local(jobs: int | None) -> Iterator[Executor]:
    """Processes of this machine, without Dask's looks at what they do 100 times a second."""
    distributed: Any = library("distributed", "cluster")
    configured: Any = library("dask.config", "cluster")
    with configured.set(QUIET):
        with _deaf_to_interrupts():
            cluster = distributed.LocalCluster(
                n_workers=jobs or cores(), threads_per_worker=1, processes=True,
                dashboard_address=None, silence_logs=logging.CRITICAL,
            )  # fmt: skip
        with cluster, _client(distributed, cluster, DASK) as client:
            yield client.get_executor(pure=False, retries=RETRIES)


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """What is started here hears no Ctrl-C; it comes to this process, once it is started.

    A terminal sends it to all processes at once, and the workers would end with tracebacks of
    their own before they are closed.  Windows has no such mask.
    """
    if os.name == "nt":
        yield
        return
    resource_tracker.ensure_running()  # which would clear the mask when the first process starts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _client(distributed: Any, address: object, name: str) -> Iterator[Any]:
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ArgumentError(
            f"the scheduler {name!r} does not answer ({type(error).__name__}). Start it with "
            "`dask scheduler` and workers with `dask worker`, or correct the address."
        ) from None
    with client:
        yield client


def _compare(client: Any, facts: Facts, asked: Callable[[], Facts]) -> None:
    """Raise where a worker's code is not this process's, or there is none."""
    client.wait_for_workers(1, timeout=PATIENCE)
    for address, theirs in client.run(asked).items():
        differ = [key for key in facts if theirs.get(key) != facts[key]]
        if differ:
            listed = ", ".join(f"{key} {theirs.get(key)} for {facts[key]}" for key in differ)
            raise ArgumentError(
                f"the worker {address} has {listed}. Install the same version there."
            )
