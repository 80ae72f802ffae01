"""Chunks of a study: a worker's task and its result, and the executors that run them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError, library
from wmr_ctrl.results import REFUSED
from wmr_ctrl.results.figures import SHARES
from wmr_ctrl.simulation.batch import cores, deaf_to_interrupts
from wmr_ctrl.simulation.many import tabulated
from wmr_ctrl.simulation.memory import Task

from .engine import Refusal, accepted, built_loops
from .plan import PlannedCase

THREADS, DASK, SCHEME = "threads", "dask", "dask://"
PATIENCE = 20.0
"""Seconds within which a scheduler has to answer."""
QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.tick.interval": "5s",
}
"""Settings that disable half of Dask's own work in a process that only computes."""
RETRIES = 3
"""Times that a chunk is sent again after its worker was lost."""
Facts = Mapping[str, str]
Columns: TypeAlias = dict[str, np.ndarray]


@dataclass(frozen=True)
class StudyChunk:
    """A worker's task: runs of a study, and the figures to compute; ``device`` as in `study`."""

    runs: tuple[tuple[PlannedCase, int], ...]
    figures: tuple[str, ...]
    device: str = "cpu"


def chunk_rows(chunk: StudyChunk, jobs: int | None) -> Columns:
    """Outcome, refusal by a guard, and figures of each run of a chunk; refused runs have none.

    Called by an executor's worker, on ``jobs`` threads, or processes for the rigid body.
    """
    cases = (case for case, _ in chunk.runs)
    loops = built_loops(cases, None, chunk.device)
    places, ready = accepted(loops, [seed for _, seed in chunk.runs])
    rows: Columns = {name: np.full(len(loops), np.nan) for name in chunk.figures}
    outcome = np.array([REFUSED] * len(loops), dtype="<U16")
    refusal = [loop.text if isinstance(loop, Refusal) else "" for loop in loops]
    if ready:
        tabulate = tabulated
        if chunk.runs[0][0].plant == "mujoco":
            from wmr_ctrl.simulation.physics.run import rigid_table

            tabulate = rigid_table
        further = [name for name in chunk.figures if name not in SHARES]
        table = tabulate([Task(loop, seed) for loop, seed in ready], further, jobs)
        columns = {"violated": table["violations"] > 0, **table}
        outcome[places] = table["outcome"]
        for name in chunk.figures:
            rows[name][places] = columns[name]
    return {"outcome": outcome, "refusal": np.array(refusal), **rows}


@contextmanager
def executor_named(
    name: str | Executor, jobs: int | None, facts: Callable[[], Facts], asked: Callable[[], Facts]
) -> Iterator[Executor | None]:
    """The executor of that name, closed at the end; None for threads of this process.

    ``facts`` returns this process's versions; ``asked`` is called on each worker for comparison.
    Raises UnknownNameError, MissingExtraError without distributed, ArgumentError for an unreachable
    scheduler or a worker of another version.
    """
    if isinstance(name, Executor):
        yield name
    elif name == THREADS:
        yield None
    elif name == DASK:
        with _local(jobs) as local:
            yield local
    elif name.startswith(SCHEME):
        distributed: Any = library("distributed", "cluster")
        with _client(distributed, f"tcp://{name.removeprefix(SCHEME)}", name) as client:
            _compare(client, facts(), asked)
            yield client.get_executor(pure=False, retries=RETRIES)
    else:
        raise UnknownNameError("executor", name, (THREADS, DASK, f"{SCHEME}HOST:PORT"))


@contextmanager
def _local(jobs: int | None) -> Iterator[Executor]:
    """Processes of this machine, without Dask's profiling of them 100 times a second."""
    distributed: Any = library("distributed", "cluster")
    configured: Any = library("dask.config", "cluster")
    with configured.set(QUIET):
        with deaf_to_interrupts():
            cluster = distributed.LocalCluster(
                n_workers=jobs or cores(), threads_per_worker=1, processes=True,
                dashboard_address=None, silence_logs=logging.CRITICAL,
            )  # fmt: skip
        with cluster, _client(distributed, cluster, DASK) as client:
            yield client.get_executor(pure=False, retries=RETRIES)


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
    """Raise if a worker's code differs from this process's, or there is no worker."""
    client.wait_for_workers(1, timeout=PATIENCE)
    for address, theirs in client.run(asked).items():
        differ = [key for key in facts if theirs.get(key) != facts[key]]
        if differ:
            listed = ", ".join(f"{key} {theirs.get(key)} for {facts[key]}" for key in differ)
            raise ArgumentError(
                f"the worker {address} runs other code ({listed}). Install the same version there."
            )
