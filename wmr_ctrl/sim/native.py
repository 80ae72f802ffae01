"""The native engine: a compiled library of one closed loop, driven by its manifest."""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Mapping
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.errors import CompilerError
from wmr_ctrl.results import Monitor
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import Signal
from wmr_ctrl.sim.structs import LONG, LONGS, REAL, REALS, Settings, loop_struct

Floats = NDArray[np.float64]
STOPS = ("", "diverged", "non-finite")


class Kernels(Protocol):
    """A built closed loop: path of the library and its manifest."""

    @property
    def library(self) -> str:
        """Path of the shared library."""

    @property
    def digest(self) -> str:
        """Hash of the sources that it was made from."""

    @property
    def manifest(self) -> Mapping[str, Any]:
        """Sizes, signals and numbers of the Systems in it."""


@cache
def load(path: str) -> ct.CDLL:
    """The library at ``path``, loaded once; raises CompilerError if it cannot be loaded."""
    try:
        library = ct.CDLL(path)
    except OSError as error:
        raise CompilerError(
            f"the compiled library {path} cannot be loaded ({error}); delete it and run again."
        ) from error
    library.wmr_run.restype = LONG
    library.wmr_run.argtypes = [ct.POINTER(Settings), ct.c_void_p, REALS]
    for name in ("wmr_size_of_settings", "wmr_size_of_loop"):
        getattr(library, name).restype = LONG
    return library


def run_native(
    kernels: Kernels, scenario: Scenario, seed: int
) -> tuple[dict[str, Floats], Monitor]:
    """One run of the compiled loop: columns by signal name, (N,) or (N, size), and the monitor.

    The call releases Python's lock, so threads run in parallel.
    """
    library, manifest = load(kernels.library), kernels.manifest
    struct = loop_struct(manifest["systems"])
    _check_sizes(library, struct)
    signals = columns_of(manifest)
    rows: Floats = np.empty((scenario.clock.samples, sum(signal.size for signal in signals)))
    settings, keep = settings_of(manifest, scenario, seed)
    state = struct()
    count = library.wmr_run(ct.byref(settings), ct.byref(state), rows.ctypes.data_as(REALS))
    del keep
    return split_columns(signals, rows[:count]), monitor_of(state, scenario.clock.plant)


def columns_of(manifest: Mapping[str, Any]) -> tuple[Signal, ...]:
    """The log's columns as Signals."""
    return tuple(Signal(**item) for item in manifest["columns"])


def split_columns(signals: tuple[Signal, ...], rows: Floats) -> dict[str, Floats]:
    """Rows of the log as one array per signal."""
    columns, at = {}, 0
    for signal in signals:
        part = rows[:, at : at + signal.size]
        columns[signal.name] = part[:, 0] if signal.size == 1 else part
        at += signal.size
    return columns


def settings_of(
    manifest: Mapping[str, Any], scenario: Scenario, seed: int
) -> tuple[Settings, list[NDArray[Any]]]:
    """``wmr_settings`` of a run, and the arrays that it points into (keep them alive)."""
    systems, phases = manifest["systems"], manifest["phases"]
    keep: list[NDArray[Any]] = []

    def pointer(numbers: Any, kind: Any = REAL) -> Any:
        array = np.ascontiguousarray(
            numbers if np.size(numbers) else [0], dtype=np.float64 if kind is REAL else np.int64
        )
        keep.append(array)
        return array.ctypes.data_as(REALS if kind is REAL else LONGS)

    clock, sensor, actuator, noise = (
        scenario.clock,
        scenario.sensor,
        scenario.actuator,
        scenario.disturbance,
    )
    delay = round(actuator.delay / clock.plant)
    settings = Settings(
        control=clock.control, plant=clock.plant, samples=clock.samples, substeps=clock.substeps,
        reference_parameters=pointer(systems["reference"]["parameter_values"]),
        controller_parameters=pointer(systems["controller"]["parameter_values"]),
        estimator_parameters=pointer(systems["estimator"]["parameter_values"]),
        plant_parameters=pointer([phase["parameters"] for phase in phases]),
        phase_start=pointer([phase["step"] for phase in phases], LONG), phases=len(phases),
        plant_start=pointer(systems["plant"]["start"]),
        controller_start=pointer(systems["controller"]["start"]),
        v_u1=scenario.limits.v_u1, pose_every=pose_every(scenario), pose_noise=sensor.pose_noise,
        correction=sensor.correction, velocity_noise=sensor.velocity_noise,
        torque_std=noise.std, torque_truncate=noise.truncate, push_torque=push_torque(scenario),
        key=noise_key(seed),
        actuator_ideal=int(actuator.ideal), delay_steps=delay,
        lag_decay=math.exp(-clock.plant / actuator.lag) if actuator.lag > 0 else 0.0,
        delay_line=pointer(np.zeros(2 * delay)),
    )  # fmt: skip
    return settings, keep


def noise_key(seed: int) -> tuple[int, int]:
    """Key of the Philox generator for a seed."""
    words = np.random.SeedSequence(seed).generate_state(2, np.uint64)
    return int(words[0]), int(words[1])


def monitor_of(state: Any, step: float) -> Monitor:
    """What the loop watched, with times in seconds."""
    first = (state.first_step * step, state.first_axis) if state.first_step >= 0 else None
    stopped = (state.stop_step * step, state.stop_axis) if state.stop else None
    speeds = (state.speed_max[0], state.speed_max[1])
    return Monitor(speeds, state.violations, first, stopped, STOPS[state.stop])


def push_torque(scenario: Scenario) -> tuple[float, float]:
    """Wheel torques [N m] of disturbance.push: of the thrust, and of the moment."""
    return pushed(scenario.disturbance.push, scenario.robot.r, scenario.robot.l)


def pushed(push: Any, r: Any, half_track: Any) -> tuple[Any, Any]:
    """The same for numbers or symbols of force (thrust, moment), wheel radius and half the track.

    The first acts on both wheels, the second on the right wheel and against the left one.
    """
    return 0.5 * r * push[0], 0.5 * r * push[1] / half_track


def pose_every(scenario: Scenario) -> int:
    """Samples from one pose measurement to the next; 0 where the pose is exact."""
    if scenario.sensor.perfect:
        return 0
    return max(1, round(scenario.sensor.pose_period / scenario.clock.control))


def _check_sizes(library: ct.CDLL, struct: type[ct.Structure]) -> None:
    if (library.wmr_size_of_settings(), library.wmr_size_of_loop()) != (
        ct.sizeof(Settings),
        ct.sizeof(struct),
    ):
        raise CompilerError(
            "the compiled library does not fit this version of wmr_ctrl; clear the build cache "
            "and run again."
        )
