"""Memory of one batch, as fmu/runtime/loop.h defines it: vectors with a number per lane.

A library contains the loop for one robot, or for lanes of robots; only the width of its memory
differs.
"""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import chain
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.compiled import LoopLayout
from wmr_ctrl.core.errors import ArgumentError, CompilerError, UnknownNameError
from wmr_ctrl.core.signals import PLANT_STATE, elements

from .runnable import RunnableLoop

Floats = NDArray[np.float64]
Numbers: TypeAlias = NDArray[np.float64] | NDArray[np.int64] | NDArray[np.uint64]
REAL: TypeAlias = ct.c_double
WORD: TypeAlias = ct.c_uint64
LONG: TypeAlias = ct.c_int64
REALS, LONGS, WORDS = ct.POINTER(REAL), ct.POINTER(LONG), ct.POINTER(WORD)
ALIGNMENT = 64
"""Bytes; the widest vector."""


class LoopSettings(ct.Structure):
    """``wmr_settings``."""

    _fields_ = (
        ("samples", LONG), ("phases", LONG), ("windows", LONG), ("phase_start", LONGS),
        ("window", LONGS), ("key", WORDS), ("cancelled", ct.POINTER(ct.c_int32)),
        ("parameters", REALS), ("start", REALS), ("queue", REALS), ("sums", REALS),
        ("log", ct.POINTER(REALS)),
    )  # fmt: skip


@dataclass(frozen=True)
class VectorSet:
    """A library's loop for one set of vector instructions, or for one robot.

    ``lanes``: robots at a time; ``row``: columns of the log.  ``run(settings, findings, state)``
    runs all lanes to the end and returns 0, or 1 if it was cancelled.
    """

    name: str
    lanes: int
    findings: int
    sums: int
    row: int
    state: int
    run: Callable[..., int]


@cache
def opened(path: str) -> ct.CDLL:
    """The library at ``path``, loaded once; raises CompilerError if it cannot be loaded."""
    try:
        return ct.CDLL(path)
    except OSError as error:
        raise CompilerError(
            f"the compiled library {path} cannot be loaded ({error}); delete it and run again."
        ) from error


@cache
def load(path: str) -> ct.CDLL:
    """`opened`, for a library of whole runs."""
    library = opened(path)
    library.wmr_set_name.restype = ct.c_char_p
    library.wmr_sizes.restype = None
    library.wmr_run.restype = ct.c_int32
    return library


@cache
def vector_sets(path: str) -> tuple[VectorSet, ...]:
    """Vector sets of the library at ``path`` that this processor can run, best first.

    Raises CompilerError if it cannot be loaded or does not fit.
    """
    library, usable = load(path), list[VectorSet]()
    while name := library.wmr_set_name(ct.c_int32(len(usable))):
        usable.append(_vector_set(library, len(usable), name.decode()))
    return tuple(usable)


def _vector_set(library: ct.CDLL, place: int, name: str) -> VectorSet:
    sizes = (LONG * 7)()
    library.wmr_sizes(ct.c_int32(place), sizes)
    if sizes[1] != ct.sizeof(LoopSettings):
        raise CompilerError(
            "the compiled library does not fit this version of wmr_ctrl; clear the build cache "
            "and run again."
        )
    run = partial(library.wmr_run, ct.c_int32(place))
    return VectorSet(name, sizes[0], sizes[2], sizes[3], sizes[4], sizes[5], run)


def vector_set(path: str, name: str | None = None) -> VectorSet:
    """The set called ``name`` of the library at ``path``, the best one without a name.

    Raises UnknownNameError if this processor or the library lacks it, CompilerError as above.
    """
    known = vector_sets(path)
    for item in known:
        if name in (None, item.name):
            return item
    raise UnknownNameError(
        "set of vector instructions", str(name), tuple(item.name for item in known)
    )


@dataclass(frozen=True)
class Task:
    """One run: a loop, the seed of its noise, and its start.

    ``start``: x, y [m], theta [rad], v1 [m/s], omega [rad/s]; None: the scenario's. ``vectors``:
    the set of vector instructions; None for the best of this processor.
    """

    loop: RunnableLoop
    seed: int
    start: tuple[float, ...] | None = None
    vectors: str | None = None

    def __post_init__(self) -> None:
        start = self.start
        if start is not None and not (len(start) == 5 and all(map(math.isfinite, start))):
            raise ArgumentError(f"start = {start!r} must be five finite numbers: x, y, theta, v.")


@dataclass(frozen=True)
class Results:
    """Results of the runs of a batch.

    ``findings``, ``state`` and ``added`` (windows, sums, lanes): one row per name, one column per
    lane; ``count``: number of lanes in use.
    """

    layout: LoopLayout
    findings: Floats
    state: Floats
    added: Floats
    logs: Sequence[Floats]
    count: int

    def row(self, name: str) -> Floats:
        """A finding of each run, (runs,)."""
        return self.findings[self.layout.findings.index(name), : self.count]

    @property
    def final(self) -> Floats:
        """The plant's state at the end of each run, (runs, 5)."""
        names = elements(self.layout.state)
        return self.state[[names.index(item.name) for item in PLANT_STATE], : self.count].T

    @property
    def sums(self) -> Floats:
        """Sums over windows, (windows, sums, runs)."""
        return self.added[:, :, : self.count]

    def sum(self, name: str) -> Floats:
        """One of the sums over all windows, (windows, runs)."""
        return self.sums[:, self.layout.sums.index(name)]

    def logged(self, lane: int) -> Floats:
        """Rows of one run's log."""
        return self.logs[lane][: int(self.row("samples")[lane])]


@dataclass(frozen=True)
class Memory(Results):
    """The settings of a batch, all arrays that they point to, and the runs' results."""

    vectors: VectorSet
    settings: LoopSettings
    arrays: Mapping[str, Numbers]

    def run(self) -> bool:
        """Run all lanes to the end; False if that was cancelled."""
        pointers = (item.ctypes.data_as(REALS) for item in (self.findings, self.state))
        return not self.vectors.run(ct.byref(self.settings), *pointers)


def laid_out(
    runs: Sequence[Task],
    windows: Sequence[tuple[int, int]],
    *,
    log: bool = False,
    cancelled: ct.c_int32 | None = None,
) -> Memory:
    """Memory for up to as many runs as there are lanes; unused lanes repeat the last run."""
    loop = runs[0].loop
    compiled, clock = loop.compiled, loop.scenario.clock
    chosen = vector_set(compiled.library, runs[0].vectors)
    if not (log or chosen.sums):
        raise ArgumentError(
            "this loop was compiled for runs with a log alone. Ask for a log, or compile it by "
            "`wmr_ctrl.simulation.engines.runnable`."
        )
    padded = [*runs, *[runs[-1]] * (chosen.lanes - len(runs))]
    added = aligned(len(windows), chosen.sums, chosen.lanes)
    starts = [list(run.loop.compiled.start) for run in padded]
    for start, run in zip(starts, padded, strict=True):
        if run.start is not None:
            start[: len(PLANT_STATE)] = run.start
    arrays: dict[str, Numbers] = {
        "parameters": _columns([[*chain(*run.loop.compiled.parameters)] for run in padded]),
        "start": _columns(starts),
        "phase_start": np.array(compiled.phase_start, dtype=np.int64),
        "window": np.array(windows, dtype=np.int64).reshape(-1, 2),
        "key": np.array([noise_key(run.seed) for run in padded], dtype=np.uint64),
        "queue": aligned(max(2 * compiled.delay_steps, 1), chosen.lanes),
        "sums": added,
    }
    settings = LoopSettings(
        samples=clock.samples, phases=len(compiled.phase_start), windows=len(windows),
        cancelled=ct.pointer(cancelled if cancelled is not None else ct.c_int32(0)),
        **{name: pointer_to(array) for name, array in arrays.items()},
    )  # fmt: skip
    logs = [np.empty((clock.samples, chosen.row)) for _ in runs] if log else []
    if log:
        settings.log = (REALS * chosen.lanes)(*(rows.ctypes.data_as(REALS) for rows in logs))
    left = aligned(chosen.findings, chosen.lanes), aligned(chosen.state, chosen.lanes)
    results = (compiled.layout, *left, added, logs, len(runs))
    return Memory(*results, chosen, settings, arrays)


def aligned(*shape: int) -> Floats:
    """Zeros at an address that is aligned for every vector type."""
    size = math.prod(shape)
    room = np.zeros(size + ALIGNMENT // 8)
    skip = -room.ctypes.data % ALIGNMENT // 8
    return room[skip : skip + size].reshape(shape)


def noise_key(seed: int) -> tuple[int, int]:
    """Key of the Philox generator for a seed."""
    words = np.random.SeedSequence(seed).generate_state(2, np.uint64)
    return int(words[0]), int(words[1])


def _columns(lanes: Sequence[Sequence[float]]) -> Floats:
    """Numbers of all lanes: one row per number, one column per lane."""
    array = aligned(max(len(lanes[0]), 1), len(lanes))
    array[: len(lanes[0])] = np.array(lanes, dtype=float).T.reshape(len(lanes[0]), len(lanes))
    return array


def pointer_to(array: Numbers) -> ct._Pointer[REAL] | ct._Pointer[LONG] | ct._Pointer[WORD]:
    """Pointer to an array's first element, with its type."""
    if array.dtype.kind == "f":
        return array.ctypes.data_as(REALS)
    return array.ctypes.data_as(LONGS if array.dtype.kind == "i" else WORDS)
