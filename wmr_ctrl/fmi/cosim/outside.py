"""Sensors, disturbances, drives and monitor of a co-simulation: the compiled ones of the loop.

The parts that are FMUs stand outside of it; what lies between them is made from the same Systems,
draws the same random numbers and watches the same limits as the native loop.
"""

from __future__ import annotations

import ctypes as ct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.codegen.build import build_outside
from wmr_ctrl.control.loop import OutsideGraphs
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.results import Monitor
from wmr_ctrl.results.monitor import STOP_REASONS
from wmr_ctrl.sim.memory import LoopSettings, Numbers, aligned, noise_key, pointer_to

Floats = NDArray[np.float64]
Pair = tuple[float, float]


@dataclass(frozen=True)
class Measurement:
    """What a sample finds: measured pose and velocity, torque and body force that disturb.

    ``logged``: further columns of the log, see `Outside.columns`.
    """

    pose: tuple[float, ...]
    velocity: tuple[float, ...]
    noise: tuple[float, ...]
    pushed: tuple[float, ...]
    logged: tuple[float, ...]


class Outside:
    """What lies between controller and plant of one run; its counters move with every call.

    ``columns``: signals of the log that effects bring; ``steady``: whether what acts stays the same
    over a sample; ``ended``: whether the run ends before its first step.
    """

    def __init__(self, setup: Setup, seed: int) -> None:
        """Everything at t = 0.  Raises CompilerError or ArgumentError."""
        graphs = OutsideGraphs(setup)
        compiled = build_outside(setup, graphs)
        self._library = ct.CDLL(compiled.library)
        self._library.wmr_outside_watch.restype = ct.c_int32
        self._findings = compiled.layout.findings
        self.columns = graphs.columns
        self.steady = graphs.steady
        self._step = setup.scenario.clock.plant
        self._arrays: dict[str, Numbers] = {
            "parameters": np.array([number for row in compiled.parameters for number in row]),
            "start": np.array(compiled.start),
            "phase_start": np.array(compiled.phase_start, dtype=np.int64),
            "window": np.zeros(2, dtype=np.int64),
            "key": np.array(noise_key(seed), dtype=np.uint64),
            "queue": aligned(max(2 * compiled.delay_steps, 1)),
            "sums": aligned(1),
        }
        pointers = {name: pointer_to(array) for name, array in self._arrays.items()}
        self._settings = LoopSettings(
            phases=len(compiled.phase_start), cancelled=ct.pointer(ct.c_int32(0)), **pointers
        )
        sizes = (ct.c_int64 * 4)()
        self._library.wmr_outside_sizes(sizes)
        self._loop = aligned(sizes[1] // 8 + 1)
        self._plant, self._held = np.zeros(5), np.zeros(6)
        self._measured, self._acting = np.zeros(sizes[2]), np.zeros(sizes[3])
        self._library.wmr_outside_start.restype = ct.c_int32
        start = self._library.wmr_outside_start
        self.ended = not start(ct.byref(self._settings), self._at(self._loop))

    def sample(self, state: Sequence[float]) -> Measurement:
        """The next control sample, for the plant's state at it."""
        self._plant[:] = state
        places = map(self._at, (self._loop, self._plant, self._measured))
        self._library.wmr_outside_sample(ct.byref(self._settings), *places)
        shown = tuple(self._measured.tolist())
        return Measurement(shown[0:3], shown[3:5], shown[5:7], shown[7:9], shown[9:])

    def step(self, torque: Sequence[float], now: Measurement) -> tuple[float, ...]:
        """Torques that act over the next plant step, disturbing torques, force on the body."""
        self._held[:] = (*torque, *now.noise, *now.pushed)
        places = map(self._at, (self._loop, self._held, self._acting))
        self._library.wmr_outside_step(ct.byref(self._settings), *places)
        return tuple(self._acting.tolist())

    def ends(self, state: Sequence[float], step: int) -> bool:
        """Take note of the plant's state after ``step`` plant steps; True if the run must end."""
        self._plant[:] = state
        places = (self._at(self._loop), self._at(self._plant))
        return not self._library.wmr_outside_watch(*places, ct.c_int64(step))

    def monitor(self, failure: str) -> Monitor:
        """What was watched."""
        numbers = np.zeros(len(self._findings))
        self._library.wmr_outside_findings(self._at(self._loop), self._at(numbers))
        seen = dict(zip(self._findings, numbers.tolist(), strict=True))
        first = (seen["first_step"] * self._step, int(seen["first_axis"]))
        stopped = (seen["stop_step"] * self._step, int(seen["stop_axis"]))
        return Monitor(
            (seen["max_v1"], seen["max_omega"]),
            int(seen["violations"]),
            first if seen["first_step"] >= 0 else None,
            stopped if seen["stop"] else None,
            STOP_REASONS[int(seen["stop"])],
            failure=failure,
        )

    @staticmethod
    def _at(array: Floats) -> ct.c_void_p:
        return ct.c_void_p(array.ctypes.data)
