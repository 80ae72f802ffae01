"""Memory of one batch, as fmu/runtime/batch.h lays it out: vectors with a number for each lane."""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.errors import CompilerError, UnknownNameError
from wmr_ctrl.results import admitted
from wmr_ctrl.sim.native import noise_key, pose_every, push_torque
from wmr_ctrl.sim.ready import Ready
from wmr_ctrl.sim.structs import LONG, LONGS, REAL, REALS, WORD

Floats = NDArray[np.float64]
ALIGNMENT = 64
"""Bytes; the widest vector."""
FINDINGS = (
    "x", "y", "theta", "v1", "omega", "max_v1", "max_omega", "violations", "first_step",
    "first_axis", "stop", "stop_step", "stop_axis", "samples", "torque", "d_least1", "d_least2",
    "left_sample", "left_axis", "clipped1", "clipped2",
)  # fmt: skip
"""Rows of the findings, in the order of WMR_FINDINGS."""


class BatchSettings(ct.Structure):
    """``wmr_batch_settings``."""

    _fields_ = (
        ("control", REAL), ("plant", REAL), ("samples", LONG), ("substeps", LONG), ("phases", LONG),
        ("pose_every", LONG), ("actuator_ideal", LONG), ("delay_steps", LONG), ("windows", LONG),
        ("phase_start", LONGS), ("window", LONGS), ("key", ct.POINTER(WORD)),
        ("cancelled", ct.POINTER(ct.c_int32)),
        ("reference_parameters", REALS), ("controller_parameters", REALS),
        ("estimator_parameters", REALS), ("plant_parameters", REALS),
        ("plant_start", REALS), ("controller_start", REALS), ("numbers", REALS),
        ("delay_line", REALS), ("sums", REALS), ("findings", REALS), ("log", ct.POINTER(REALS)),
    )  # fmt: skip


@dataclass(frozen=True)
class VectorSet:
    """A library's loop for one set of vector instructions.

    ``lanes``: robots at a time; ``findings``, ``sums``, ``row``: numbers of each lane.
    """

    name: str
    lanes: int
    findings: int
    sums: int
    row: int
    run: Callable[..., int]


@cache
def vector_sets(path: str) -> tuple[VectorSet, ...]:
    """What of the library at ``path`` this processor can run, best first.

    Raises CompilerError if it cannot be loaded or does not fit.
    """
    try:
        loaded = ct.CDLL(path)
    except OSError as error:
        raise CompilerError(
            f"the compiled library {path} cannot be loaded ({error}); delete it and run again."
        ) from error
    loaded.wmr_batch_set.restype = ct.c_char_p
    loaded.wmr_batch_sizes.restype = None
    loaded.wmr_run_batch.restype = ct.c_int32
    found: list[VectorSet] = []
    while name := loaded.wmr_batch_set(ct.c_int32(len(found))):
        found.append(_vector_set(loaded, len(found), name.decode()))
    return tuple(found)


def _vector_set(loaded: ct.CDLL, place: int, name: str) -> VectorSet:
    sizes = (LONG * 5)()
    loaded.wmr_batch_sizes(ct.c_int32(place), sizes)
    if (sizes[1], sizes[2]) != (ct.sizeof(BatchSettings), len(FINDINGS)):
        raise CompilerError(
            "the compiled library does not fit this version of wmr_ctrl; clear the build cache "
            "and run again."
        )
    run = partial(loaded.wmr_run_batch, ct.c_int32(place))
    return VectorSet(name, sizes[0], sizes[2], sizes[3], sizes[4], run)


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


class Run(Protocol):
    """What a lane needs of a task."""

    @property
    def loop(self) -> Ready:
        """Kernels, scenario and bounds."""

    @property
    def seed(self) -> int:
        """Seed of the noise."""

    @property
    def start(self) -> tuple[float, ...] | None:
        """Plant state at t = 0, if it is not the scenario's."""

    @property
    def vectors(self) -> str | None:
        """Name of the set of vector instructions; None for the best."""


@dataclass(frozen=True)
class Memory:
    """The settings of a batch and every array that they point into."""

    settings: BatchSettings
    arrays: Mapping[str, NDArray[Any]]
    count: int

    def found(self, *names: str) -> Floats:
        """Rows of FINDINGS for each run: (runs,), or (runs, names) for several."""
        rows: Floats = self.arrays["findings"][[FINDINGS.index(name) for name in names]]
        return rows[0, : self.count] if len(names) == 1 else rows[:, : self.count].T

    @property
    def sums(self) -> Floats:
        """Sums over windows, (windows, sums, runs)."""
        return self.arrays["sums"][:, :, : self.count]

    def logged(self, lane: int) -> Floats:
        """Rows of one run's log."""
        rows: Floats = self.arrays[f"log{lane}"][: int(self.found("samples")[lane])]
        return rows


def laid_out(
    runs: Sequence[Run],
    windows: Sequence[tuple[int, int]],
    *,
    log: bool = False,
    cancelled: ct.c_int32 | None = None,
) -> Memory:
    """Memory for up to as many runs as there are lanes; the lanes left over repeat the last run."""
    loop = runs[0].loop
    chosen = vector_set(loop.kernels.library, runs[0].vectors)
    padded = [*runs, *[runs[-1]] * (chosen.lanes - len(runs))]
    phases, scenario = loop.kernels.manifest["phases"], loop.scenario
    clock, delay = scenario.clock, round(scenario.actuator.delay / scenario.clock.plant)
    arrays = _numbers(padded)
    arrays |= {
        "phase_start": np.array([phase["step"] for phase in phases], dtype=np.int64),
        "window": np.array(windows, dtype=np.int64).reshape(-1, 2),
        "key": np.array([noise_key(run.seed) for run in padded], dtype=np.uint64),
        "delay_line": aligned(max(2 * delay, 1), chosen.lanes),
        "sums": aligned(len(windows), chosen.sums, chosen.lanes),
        "findings": aligned(chosen.findings, chosen.lanes),
    }
    settings = BatchSettings(
        control=clock.control, plant=clock.plant, samples=clock.samples, substeps=clock.substeps,
        phases=len(phases), pose_every=pose_every(scenario),
        actuator_ideal=int(scenario.actuator.ideal), delay_steps=delay, windows=len(windows),
        cancelled=ct.pointer(cancelled if cancelled is not None else ct.c_int32(0)),
        **{name: array.ctypes.data_as(_kind(array)) for name, array in arrays.items()},
    )  # fmt: skip
    if log:
        logs = [np.empty((clock.samples, chosen.row)) for _ in runs]
        arrays |= {f"log{lane}": rows for lane, rows in enumerate(logs)}
        settings.log = (REALS * chosen.lanes)(*(rows.ctypes.data_as(REALS) for rows in logs))
    return Memory(settings, arrays, len(runs))


def aligned(*shape: int) -> Floats:
    """Zeros at an address that every vector type can be read from."""
    size = math.prod(shape)
    room = np.zeros(size + ALIGNMENT // 8)
    skip = -room.ctypes.data % ALIGNMENT // 8
    return room[skip : skip + size].reshape(shape)


def _numbers(runs: Sequence[Run]) -> dict[str, NDArray[Any]]:
    """The vectors that hold a number for each lane."""
    rows: dict[str, list[list[float]]] = {}
    for run in runs:
        for name, values in _numbers_of(run).items():
            rows.setdefault(name, []).append(values)
    found = {}
    for name, lanes in rows.items():
        array = aligned(max(len(lanes[0]), 1), len(lanes))
        array[: len(lanes[0])] = np.array(lanes, dtype=float).T.reshape(len(lanes[0]), len(lanes))
        found[name] = array
    return found


def _numbers_of(run: Run) -> dict[str, list[float]]:
    manifest = run.loop.kernels.manifest
    systems, phases = manifest["systems"], manifest["phases"]
    return {
        **{
            f"{role}_parameters": systems[role]["parameter_values"]
            for role in ("reference", "controller", "estimator")
        },
        "plant_parameters": [value for phase in phases for value in phase["parameters"]],
        "plant_start": list(run.start or systems["plant"]["start"]),
        "controller_start": systems["controller"]["start"],
        "numbers": _lane_numbers(run.loop),
    }


def _lane_numbers(loop: Ready) -> list[float]:
    """In the order of WMR_NUMBERS."""
    scenario = loop.scenario
    sensor, noise, lag = scenario.sensor, scenario.disturbance, scenario.actuator.lag
    decay = math.exp(-scenario.clock.plant / lag) if lag > 0 else 0.0
    return [
        *scenario.limits.v_u1, sensor.pose_noise, sensor.correction, *sensor.velocity_noise,
        noise.std, noise.truncate, decay, *push_torque(scenario), *admitted(*loop.bounds),
    ]  # fmt: skip


def _kind(array: NDArray[Any]) -> Any:
    kinds: dict[Any, Any] = {"f": REALS, "i": LONGS, "u": ct.POINTER(WORD)}
    return kinds[array.dtype.kind]
