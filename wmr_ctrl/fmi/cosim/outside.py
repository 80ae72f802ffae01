"""Sensors, disturbances, drives and monitor of a co-simulation: the compiled ones of the loop.

The parts that are FMUs stand outside of it; what lies between them is made from the same Systems,
draws the same random numbers and watches the same limits as the native loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from wmr_ctrl.codegen.build import build_outside
from wmr_ctrl.control.loop import PlantlessGraphs
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.results import Monitor
from wmr_ctrl.sim.coupled import Coupled


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
    over a sample; ``rolling``: what the sensors ask of the plant beside its state; ``ended``:
    whether the run ends before its first step.
    """

    def __init__(self, setup: Setup, seed: int) -> None:
        """Everything at t = 0.  Raises CompilerError or ArgumentError."""
        graphs = PlantlessGraphs(setup)
        compiled = build_outside(setup, graphs)
        self.columns, self.steady, self.rolling = graphs.columns, graphs.steady, graphs.rolling
        self._coupled = Coupled(compiled, seed, setup.scenario.clock.plant)
        self.ended = self._coupled.ended

    def sample(self, state: Sequence[float]) -> Measurement:
        """The next control sample, for the plant's state at it."""
        shown = tuple(self._coupled.sampled(state))
        return Measurement(shown[0:3], shown[3:5], shown[5:7], shown[7:9], shown[9:])

    def step(self, torque: Sequence[float], now: Measurement) -> tuple[float, ...]:
        """Torques that act over the next plant step, disturbing torques, force on the body."""
        return tuple(self._coupled.acting((*torque, *now.noise, *now.pushed)))

    def ends(self, state: Sequence[float], step: int) -> bool:
        """Take note of the plant's state after ``step`` plant steps; True if the run must end."""
        return self._coupled.ends(state, step)

    def monitor(self, failure: str) -> Monitor:
        """What was watched."""
        return self._coupled.monitor(failure)
