"""Where the chunks of a study run: threads here, any `concurrent.futures` executor, or Dask."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from wmr_ctrl.campaign.study_plan import library
from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.sim.batch import cores

THREADS, DASK, SCHEME = "threads", "dask", "dask://"
PATIENCE = 20.0
"""Seconds within which a scheduler has to answer."""
RETRIES = 3
"""How often a chunk is sent again after its worker was lost."""

Facts = Mapping[str, str]


@contextmanager
def executor_named(
    name: str | Executor, jobs: int | None, facts: Facts, asked: Callable[[], Facts]
) -> Iterator[Executor | None]:
    """The executor of that name, closed at the end; None for threads of this process.

    ``facts`` are this process's versions; ``asked`` is what each worker is asked to compare.
    Raises UnknownNameError, MissingExtraError without distributed, ArgumentError for a scheduler
    that does not answer or a worker of another version.
    """
    if isinstance(name, Executor):
        yield name
    elif name == THREADS:
        yield None
    elif name == DASK or name.startswith(SCHEME):
        with _dask(name, jobs, facts, asked) as executor:
            yield executor
    else:
        raise UnknownNameError("executor", name, (THREADS, DASK, f"{SCHEME}HOST:PORT"))


@contextmanager
def _dask(
    name: str, jobs: int | None, facts: Facts, asked: Callable[[], Facts]
) -> Iterator[Executor]:
    distributed: Any = library("distributed", "cluster")
    local = None
    if name == DASK:
        local = distributed.LocalCluster(
            n_workers=jobs or cores(), threads_per_worker=1, processes=True, dashboard_address=None
        )
    try:
        with _client(distributed, local or f"tcp://{name.removeprefix(SCHEME)}", name) as client:
            _compare(client, facts, asked)
            yield client.get_executor(pure=False, retries=RETRIES)
    finally:
        if local is not None:
            local.close()


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
