"""Memory of one batch, as fmu/runtime/batch.h lays it out: vectors with a number for each lane."""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.errors import CompilerError
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.native import Kernels, noise_key, pose_every, push_torque
from wmr_ctrl.sim.structs import LONG, LONGS, REAL, REALS, WORD

Floats = NDArray[np.float64]
ALIGNMENT = 64
"""Bytes; the widest vector."""


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
        ("delay_line", REALS), ("sums", REALS), ("findings", REALS), ("log", REALS),
    )  # fmt: skip


@dataclass(frozen=True)
class BatchLibrary:
    """A library for lanes: their number, rows of findings, sums and log, and its one function."""

    lanes: int
    findings: int
    sums: int
    row: int
    run: Callable[..., int]


@cache
def library_of(path: str) -> BatchLibrary:
    """The library at ``path``; raises CompilerError if it cannot be loaded or does not fit."""
    try:
        loaded = ct.CDLL(path)
    except OSError as error:
        raise CompilerError(
            f"the compiled library {path} cannot be loaded ({error}); delete it and run again."
        ) from error
    sizes = (LONG * 5)()
    loaded.wmr_batch_sizes.restype = None
    loaded.wmr_batch_sizes(sizes)
    if sizes[1] != ct.sizeof(BatchSettings):
        raise CompilerError(
            "the compiled library does not fit this version of wmr_ctrl; clear the build cache "
            "and run again."
        )
    loaded.wmr_run_batch.restype = ct.c_int32
    return BatchLibrary(sizes[0], sizes[2], sizes[3], sizes[4], loaded.wmr_run_batch)


class Run(Protocol):
    """What a lane needs of a task."""

    @property
    def kernels(self) -> Kernels:
        """The library and its manifest."""

    @property
    def scenario(self) -> Scenario:
        """Clocks, sensors, actuators, noise."""

    @property
    def seed(self) -> int:
        """Seed of the noise."""

    @property
    def start(self) -> tuple[float, ...] | None:
        """Plant state at t = 0, if it is not the scenario's."""


@dataclass(frozen=True)
class Memory:
    """The settings of a batch and every array that they point into."""

    settings: BatchSettings
    arrays: Mapping[str, NDArray[Any]]
    count: int

    @property
    def findings(self) -> Floats:
        """What was found, (findings, runs)."""
        return self.arrays["findings"][:, : self.count]

    @property
    def sums(self) -> Floats:
        """Sums over windows, (windows, sums, runs)."""
        return self.arrays["sums"][:, :, : self.count]

    def logged(self, lane: int) -> Floats:
        """Rows of one run's log."""
        made = int(self.findings[-2, lane])
        return self.arrays["log"][:made, :, lane]


def laid_out(
    runs: Sequence[Run],
    windows: Sequence[tuple[int, int]],
    *,
    log: bool = False,
    cancelled: ct.c_int32 | None = None,
) -> Memory:
    """Memory for up to as many runs as there are lanes; the lanes left over repeat the last run."""
    library = library_of(runs[0].kernels.library)
    padded = [*runs, *[runs[-1]] * (library.lanes - len(runs))]
    first, scenario = runs[0].kernels.manifest, runs[0].scenario
    clock, delay = scenario.clock, round(scenario.actuator.delay / scenario.clock.plant)
    arrays = _numbers(padded)
    arrays |= {
        "phase_start": np.array([phase["step"] for phase in first["phases"]], dtype=np.int64),
        "window": np.array(windows, dtype=np.int64).reshape(-1, 2),
        "key": np.array([noise_key(run.seed) for run in padded], dtype=np.uint64),
        "delay_line": aligned(max(2 * delay, 1), library.lanes),
        "sums": aligned(len(windows), library.sums, library.lanes),
        "findings": aligned(library.findings, library.lanes),
    }
    if log:
        arrays["log"] = aligned(clock.samples, library.row, library.lanes)
    settings = BatchSettings(
        control=clock.control, plant=clock.plant, samples=clock.samples, substeps=clock.substeps,
        phases=len(first["phases"]), pose_every=pose_every(scenario),
        actuator_ideal=int(scenario.actuator.ideal), delay_steps=delay, windows=len(windows),
        cancelled=ct.pointer(cancelled if cancelled is not None else ct.c_int32(0)),
        **{name: array.ctypes.data_as(_kind(array)) for name, array in arrays.items()},
    )  # fmt: skip
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
    systems, phases = run.kernels.manifest["systems"], run.kernels.manifest["phases"]
    return {
        **{
            f"{role}_parameters": systems[role]["parameter_values"]
            for role in ("reference", "controller", "estimator")
        },
        "plant_parameters": [value for phase in phases for value in phase["parameters"]],
        "plant_start": list(run.start or systems["plant"]["start"]),
        "controller_start": systems["controller"]["start"],
        "numbers": _lane_numbers(run.scenario),
    }


def _lane_numbers(scenario: Scenario) -> list[float]:
    """In the order of WMR_NUMBERS."""
    sensor, noise, lag = scenario.sensor, scenario.disturbance, scenario.actuator.lag
    decay = math.exp(-scenario.clock.plant / lag) if lag > 0 else 0.0
    return [
        *scenario.limits.v_u1, sensor.pose_noise, sensor.correction, *sensor.velocity_noise,
        noise.std, noise.truncate, decay, *push_torque(scenario),
    ]  # fmt: skip


def _kind(array: NDArray[Any]) -> Any:
    kinds: dict[Any, Any] = {"f": REALS, "i": LONGS, "u": ct.POINTER(WORD)}
    return kinds[array.dtype.kind]
