"""The gate as a compiled C function with its memory."""

from __future__ import annotations

from collections.abc import Sequence

from wmr_ctrl.filter.gate import GATE_FLAGS, Gated, GateSettings, gate_system
from wmr_ctrl.ros2.compiled_system import CompiledSystem
from wmr_ctrl.scenario import Scenario

NONE = -1.0
"""Age of what never came [s]."""
PAIR = (0.0, 0.0)
"""Velocities [m/s, rad/s] where there are none."""


class Gate:
    """A gate's C function and its memory."""

    def __init__(self, scenario: Scenario, settings: GateSettings) -> None:
        """Compile the graph, unless it is in the cache.

        Raises ScenarioError where the filter is not set or cannot be met, CompilerError.
        """
        self._function = CompiledSystem(gate_system(scenario, settings), "gate")
        self.period = scenario.clock.control

    def start(self) -> None:
        """Begin anew: no command, nothing latched, the base anywhere within its limits."""
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
    ) -> Gated:
        """The command (v [m/s], omega [rad/s]) that goes to the base, and its report.

        Ages [s] are counted since a message was taken, negative: there is none; ``elapsed`` [s]
        since the last step, 0: the period.  ``stop`` latches zeros until ``reset``.  Flags: those
        of `wmr_ctrl.filter.CommandFilter.step`, and "stopped", "no-command", "no-odometry",
        "too-fast" (odometry contradicts the bounds: stopped), "ramped".
        """
        v, omega, bits = self._function.step(
            (*command, command_age, *odometry, odometry_age, elapsed, stop, reset)
        )
        names = tuple(name for bit, name in GATE_FLAGS.items() if int(bits) & bit)
        return Gated((v, omega), names)
