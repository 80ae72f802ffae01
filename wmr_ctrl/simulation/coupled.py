"""A compiled loop with an external plant, sample by sample and step by step."""

import ctypes as ct
from collections.abc import Sequence

import numpy as np

from wmr_ctrl.core.compiled import CompiledLoop
from wmr_ctrl.results import Monitor

from .figures import monitor
from .memory import LoopSettings, Numbers, aligned, noise_key, opened, pointer_to


class Coupled:
    """The loop of one run without its plant; every call advances its counters.

    ``ended``: whether the run ends before its first step.
    """

    def __init__(self, compiled: CompiledLoop, seed: int, step: float) -> None:
        """Set everything to t = 0; ``step`` [s] is the plant's.  Raises CompilerError."""
        self._library, self._step = opened(compiled.library), step
        self._findings = compiled.layout.findings
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
        self._given, self._held = (ct.c_double * 16)(), (ct.c_double * 16)()
        self._shown, self._acting = (ct.c_double * sizes[2])(), (ct.c_double * sizes[3])()
        self._at = ct.byref(self._settings), ct.c_void_p(self._loop.ctypes.data)
        self._library.wmr_outside_start.restype = ct.c_int32
        self._library.wmr_outside_watch.restype = ct.c_int32
        self.ended = not self._library.wmr_outside_start(*self._at)

    def sampled(self, state: Sequence[float]) -> list[float]:
        """Outputs of the next control sample for the plant's present state."""
        self._given[: len(state)] = list(state)
        self._library.wmr_outside_sample(*self._at, self._given, self._shown)
        return self._shown[:]

    def acting(self, held: Sequence[float]) -> list[float]:
        """Torques over the next plant step, disturbing torques, force on the body.

        ``held`` are the values that the sample passes to its steps, the commanded torques first.
        """
        self._held[: len(held)] = list(held)
        self._library.wmr_outside_step(*self._at, self._held, self._acting)
        return self._acting[:]

    def ends(self, state: Sequence[float], step: int) -> bool:
        """Record the plant's state after ``step`` plant steps; True if the run must end."""
        self._given[: len(state)] = list(state)
        watch = self._library.wmr_outside_watch
        return not watch(self._at[1], self._given, ct.c_int64(step))

    def monitor(self, failure: str = "") -> Monitor:
        """Monitor of the steps so far."""
        numbers = (ct.c_double * len(self._findings))()
        self._library.wmr_outside_findings(self._at[1], numbers)
        return monitor(dict(zip(self._findings, numbers, strict=True)), self._step, failure=failure)
