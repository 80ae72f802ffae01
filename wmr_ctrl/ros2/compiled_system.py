"""A sampled System, and the gate, as a compiled C function with its memory."""

import ctypes
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.kernels import controller_kernel
from wmr_ctrl.codegen.resources import c_texts
from wmr_ctrl.codegen.source import plain_sources
from wmr_ctrl.codegen.toolchain import build_library
from wmr_ctrl.control.filter.gate import GATE_FLAGS, Gated, GateSettings, gate_system
from wmr_ctrl.world.model.system import System, values
from wmr_ctrl.world.scenario import Scenario

VISIBLE = ("-fvisibility=default",)
"""The library is the kernel alone, which is called by its name."""


class CompiledSystem:
    """A System's C function; one step from Python takes some microseconds.

    ``x`` is the state, in the order of the System's; it may be changed in place.
    """

    def __init__(self, system: System, name: str) -> None:
        """Compile the graph, unless it is in the cache.  Raises CompilerError."""
        kernel = controller_kernel(system, name)
        sources = plain_sources([kernel], name) | c_texts(HEADER)
        path = build_library(sources, name=name, flags=VISIBLE)
        self._step = ctypes.CDLL(str(path))[f"wmr_{name}"]
        self._step.restype = None
        self.start_values: NDArray[np.float64] = np.array(system.x0)
        self.x: NDArray[np.float64] = self.start_values.copy()
        self._u, self._y = np.zeros(system.u.numel()), np.zeros(system.y.numel())
        self._p, self._next = np.array(system.p0), self.x.copy()
        arrays = (self._u, self.x, self._p, self._next, self._y)
        self._pointers = [ctypes.c_void_p(item.ctypes.data) for item in arrays]

    def start(self) -> None:
        """Compile the graph, or load it from the cache.  Raises CompilerError."""
        self.x[:] = self.start_values

    def look(self, u: Sequence[float]) -> list[float]:
        """Compute the outputs for inputs ``u``; the state changes only with `move`."""
        self._u[:] = u
        self._step(*self._pointers)
        return self._y.tolist()

    def move(self) -> None:
        """Commit the state of the last `look`."""
        self.x[:] = self._next

    def step(self, u: Sequence[float]) -> list[float]:
        """The outputs for inputs ``u``, and the next state."""
        y = self.look(u)
        self.move()
        return y


NONE = -1.0
"""Age of what never came [s]."""
PAIR = (0.0, 0.0)
"""Velocities [m/s, rad/s] where there are none."""
OWN_INPUTS = 9
"""Numbers that each gate takes, before limits and free distances."""


class Gate:
    """A gate's C function and its memory."""

    def __init__(self, scenario: Scenario, settings: GateSettings) -> None:
        """Compile the graph, or load it from the cache.

        Raises ScenarioError if no filter is set or its limit cannot be kept, CompilerError.
        """
        system = gate_system(scenario, settings)
        self._function = CompiledSystem(system, "gate")
        self._untold = values(system.inputs)[OWN_INPUTS:]
        self.period = scenario.clock.control

    def start(self) -> None:
        """Reset: no command, nothing latched, the base anywhere within its limits."""
        self._function.start()

    def step(
        self,
        command: Sequence[float] = PAIR,
        command_age: float = NONE,
        odometry: Sequence[float] = PAIR,
        odometry_age: float = NONE,
        elapsed: float = 0.0,
        *,
        stop: bool = False,
        reset: bool = False,
        told: Sequence[float] = (),
    ) -> Gated:
        """The command (v [m/s], omega [rad/s]) that goes to the base, and its report.

        Ages [s] are measured from a message's arrival; negative: no message; ``elapsed`` [s] since
        the last step, 0: the period.  ``stop`` latches zeros until ``reset``.  ``told``: limits,
        free distances and their age if the filter has such inputs, by default none.  Flags: those
        of `wmr_ctrl.control.filter.CommandFilter.step`, and "stopped", "no-command", "no-odometry",
        "too-fast" (odometry contradicts the bounds: stopped), "ramped".
        """
        v, omega, bits = self._function.step(
            (
                *command,
                command_age,
                *odometry,
                odometry_age,
                elapsed,
                stop,
                reset,
                *(told or self._untold),
            )
        )
        names = tuple(name for bit, name in GATE_FLAGS.items() if int(bits) & bit)
        return Gated((v, omega), names)
