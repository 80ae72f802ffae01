"""Wiring: Systems of one rate connected by the names of their signals, with common parameters.

The surroundings of plant and controller are connected here, for the whole loop and for parts of it
that are coupled from outside: sensors and disturbances in a control sample, disturbances and drives
in a plant step.
"""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca

from wmr_ctrl.core import signals
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.effect import EffectRole, Rate
from wmr_ctrl.world.model.system import NORMAL, Draw, Parameters, Port, System, port, stack

from .setup import Setup

Named: TypeAlias = dict[str, ca.SX]
STREAMS = {"torque": 0, "pose": 1, "velocity": 2}
"""Streams whose numbers are fixed; others follow from their names."""
FIRST_STREAM = 16


@dataclass(frozen=True)
class Stream:
    """Random numbers of one draw: their stream, kind, count and rate.

    ``said``: graph of whether they are needed and of their bound (2,), as functions of the loop's
    parameters.
    """

    draw: Draw
    rate: Rate
    said: ca.SX

    @property
    def name(self) -> str:
        """Name of the stream."""
        return self.draw.port.signal.name

    @property
    def number(self) -> int:
        """Number of the stream in the generator's counter; it depends only on the name."""
        return STREAMS.get(self.name, FIRST_STREAM + zlib.crc32(self.name.encode()))

    @property
    def size(self) -> int:
        """Size of the draw."""
        return self.draw.port.signal.size

    @property
    def normal(self) -> bool:
        """True if normal; else uniform on [-1, 1)."""
        return self.draw.kind == NORMAL


class Wiring:
    """Signals by name at one rate, and the state of its Systems.

    ``clock`` is the index of the sample or step; ``known`` starts with the time and the true state;
    ``shown`` are diagnostics of effects.
    """

    def __init__(self, setup: Setup, parameters: Parameters, rate: Rate, true: Named) -> None:
        sampled = rate is Rate.SAMPLE
        self.setup, self.parameters, self.rate = setup, parameters, rate
        self.clock = port(signals.SAMPLE if sampled else signals.STEP)
        time = self.clock.sym * parameters.take("clock.control" if sampled else "clock.plant")
        own = {signals.TIME.name: time, self.clock.signal.name: self.clock.sym}
        self.known: Named = {**true, **own}
        self.state: list[Port] = []
        self.following: list[ca.SX] = []
        self.streams: list[Stream] = []
        self.shown: list[signals.Signal] = []

    def of(self, system: System) -> ca.SX:
        """The common symbols for a System's parameters."""
        return stack(self.parameters.take(item.signal.name) for item in system.params)

    def run(self, system: System, known: Mapping[str, ca.SX] | None = None) -> Named:
        """Outputs and diagnostics of a System for the known signals; its state is added."""
        p, inputs = self.of(system), self.known if known is None else known
        for item in system.draws:
            said = ca.substitute(ca.vertcat(item.wanted, item.bound), system.p, p)
            self.streams.append(Stream(item, self.rate, said))
        given = [stack(inputs[item.signal.name] for item in system.inputs), system.x, p]
        graph = system.function("run", [system.update, system.y, system.d])
        update, y, d = graph(*given, *([system.w] if system.draws else []))
        self.add(system.state, update)
        shown = signals.places(item.signal for item in (*system.outputs, *system.diagnostics))
        return {name: ca.vertcat(y, d)[rows] for name, rows in shown.items()}

    def add(self, state: Sequence[Port], following: ca.SX) -> None:
        """Add state with its next value."""
        self.state.extend(state)
        self.following.append(following)

    def effects(self, role: EffectRole) -> list[System]:
        """Systems of one role that act at this rate, in the order in which they are composed."""
        chosen = (item for item in self.setup.with_role(role) if item.rate is self.rate)
        return [item.system(self.setup.scenario) for item in chosen]

    def drives(self) -> list[System]:
        """Systems from a command to torques: commands, the speed loop, then the drives."""
        roles = (EffectRole.COMMAND, EffectRole.LOOP, EffectRole.DRIVE)
        return [system for role in roles for system in self.effects(role)]

    def measure(self, sensors: Sequence[System]) -> None:
        """Apply the sensors one after the other, the first to the true state."""
        for seen, true in zip(signals.MEASURED, signals.PLANT_STATE, strict=True):
            self.known[seen.name] = self.known[true.name]
        for system in sensors:
            self.known |= self._shown(system)

    def disturb(self, disturbances: Sequence[System]) -> None:
        """Add the torques at the wheels and the forces on the body to those already known."""
        total = {s.name: self.known.get(s.name, ca.SX(0)) for s in signals.DISTURBING}
        for system in disturbances:
            given = self._shown(system)
            total |= {name: total[name] + given.pop(name) for name in total if name in given}
            self.known |= given
        self.known |= total

    def drive(self, drives: Sequence[System]) -> ca.SX:
        """Apply the drives one after the other to the arrived command; returns the delay [s].

        For a base that takes velocities, effects on the command and the speed loop come first.

        Raises ArgumentError for a delay behind another drive.
        """
        late = ca.SX(0)
        for place, system in enumerate(drives):
            if system.transport is None:
                self.known |= self._shown(system)
            elif place:
                raise ArgumentError(f"{system.name}: a delay must be the first of the drives.")
            else:
                late = ca.substitute(system.transport, system.p, self.of(system))
        return late

    def _shown(self, system: System) -> Named:
        self.shown.extend(item.signal for item in system.diagnostics)
        return self.run(system)

    def column(self, wanted: Sequence[signals.Signal]) -> ca.SX:
        """Values of the wanted signals, stacked."""
        return stack(self.known[item.name] for item in wanted)


def pushes(systems: Sequence[System]) -> bool:
    """True if a disturbance exerts a force on the body."""
    names = {item.name for item in signals.BODY_FORCE}
    return any(item.signal.name in names for system in systems for item in system.outputs)


def held_signals(setup: Setup, pushed: bool) -> tuple[signals.Signal, ...]:
    """Signals held over a sample, the commanded torques or velocities first."""
    return (*setup.commanded, *signals.TORQUE_NOISE, *(signals.BODY_FORCE if pushed else ()))
