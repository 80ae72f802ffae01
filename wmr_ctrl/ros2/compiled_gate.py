"""The gate as a compiled C function with its memory."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.kernels import controller_kernel
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.source import plain_sources
from wmr_ctrl.codegen.toolchain import build_library
from wmr_ctrl.filter.gate import GATE_FLAGS, Gated, GateSettings, gate_system
from wmr_ctrl.scenario import Scenario

NONE = -1.0
"""Age of what never came [s]."""
VISIBLE = ("-fvisibility=default",)
"""The library is the kernel alone, which is called by its name."""
_PAIR = (0.0, 0.0)


class Gate:
    """A gate's C function and its memory: a step takes some microseconds from Python."""

    def __init__(self, scenario: Scenario, settings: GateSettings) -> None:
        """Compile the graph, unless it is in the cache.

        Raises ScenarioError where the filter is not set or cannot be met, CompilerError.
        """
        system = gate_system(scenario, settings)
        kernel = controller_kernel(system, "gate")
        header = {HEADER: (runtime_dir() / HEADER).read_text(encoding="utf-8")}
        path = build_library(plain_sources([kernel], "gate") | header, name="gate", flags=VISIBLE)
        self._step = ctypes.CDLL(str(path)).wmr_gate
        self._step.restype = None
        self.period = system.period
        self._start = np.array(system.x0)
        self._u, self._y = np.zeros(system.u.numel()), np.zeros(system.y.numel())
        self._x, self._next = self._start.copy(), self._start.copy()
        self._p = np.array(system.p0)
        arrays = (self._u, self._x, self._p, self._next, self._y)
        self._pointers = [ctypes.c_void_p(item.ctypes.data) for item in arrays]

    def start(self) -> None:
        """Begin anew: no command, nothing latched, the base anywhere within its limits."""
        self._x[:] = self._start

    def step(
        self,
        command: Sequence[float] = _PAIR,
        command_age: float = NONE,
        odometry: Sequence[float] = _PAIR,
        odometry_age: float = NONE,
        elapsed: float = 0.0,
        *,
        stop: bool = False,
        reset: bool = False,
    ) -> Gated:
        """The command (v [m/s], omega [rad/s]) that goes to the base, and what is told of it.

        Ages [s] are counted since a message was taken, negative: there is none; ``elapsed`` [s]
        since the last step, 0: the period.  ``stop`` latches zeros until ``reset``.  Flags: those
        of `wmr_ctrl.filter.CommandFilter.step`, and "stopped", "no-command", "no-odometry",
        "too-fast" (odometry contradicts the bounds: stopped), "ramped".
        """
        self._u[:] = (*command, command_age, *odometry, odometry_age, elapsed, stop, reset)
        self._step(*self._pointers)
        self._x[:] = self._next
        v, omega, bits = self._y.tolist()
        names = tuple(name for bit, name in GATE_FLAGS.items() if int(bits) & bit)
        return Gated((v, omega), names)
