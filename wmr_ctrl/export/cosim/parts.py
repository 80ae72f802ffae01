"""The three parts of a co-simulation: reference, controller and plant, in our names and units."""

import math
from collections import deque
from collections.abc import Iterator, Sequence
from functools import cache

import casadi as ca

from wmr_ctrl.control.filter.channels import BOUNDS_LEFT, FLAGS, SENT
from wmr_ctrl.control.filter.heard import ODOMETRY
from wmr_ctrl.control.guard.guard import linear_first
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import (
    ASKED,
    FORCE,
    GUARD_DIAGNOSTICS,
    ODOMETRY_AGE,
    VELOCITY,
    Signal,
    elements,
)
from wmr_ctrl.world.model.dynamics import force_to_wheel, full_thrust, wheel_to_force
from wmr_ctrl.world.scenario import Robot

from . import mapping
from .slave import Slave

GUARD_SHOWN = (*mapping.TORQUES, *elements(GUARD_DIAGNOSTICS))
FILTER_SHOWN = (*SENT.elements, FLAGS.name)
"""Outputs that are read from a guard and from a command filter."""
GUARDED = (*FORCE.elements, *(s.name for s in VELOCITY), ODOMETRY_AGE.name)
FILTERED = (*ASKED.elements, *ODOMETRY.elements, ODOMETRY_AGE.name)
"""Sources of a guard, and of a command filter."""
FILTERING = (*GUARD_DIAGNOSTICS, ASKED, FLAGS)
"""Outputs of a command filter as a part of its own, named as in laws that contain one."""
_SHOWN = tuple(mapping.SEEN.index(item.name) for item in (*VELOCITY, ODOMETRY_AGE))
_ASKED = len(FORCE.elements)


class Part:
    """An FMU with the maps of its inputs and outputs.

    ``write`` takes the values of ``sources``; ``read`` returns those of ``targets``; ``uses`` are
    the sources that the inputs depend on; ``foreign``: a foreign FMU with a map, whose outputs must
    be finite; ``is_base``: a plant that takes velocities.
    """

    def __init__(
        self,
        slave: Slave,
        inputs: Sequence[mapping.MapRow],
        outputs: Sequence[mapping.MapRow],
        sources: Sequence[str],
        step: float | None = None,
        *,
        foreign: bool = False,
    ) -> None:
        self.slave, self.targets, self.step_size = slave, tuple(row.target for row in outputs), step
        self.foreign = foreign
        theirs = list(dict.fromkeys(name for row in outputs for name, _ in row.terms))
        self.uses = frozenset(name for row in inputs for name, _ in row.terms)
        self.wants_ready = not self.uses.isdisjoint(mapping.READY)
        self.is_base = not self.uses.isdisjoint((*mapping.COMMANDED, *mapping.WHEELS))
        self._inward = mapping.compiled(inputs, sources)
        self._write = slave.writer([row.target for row in inputs])
        self._read, self._outward = slave.reader(theirs), mapping.compiled(outputs, theirs)

    def write(self, values: Sequence[float]) -> None:
        """Set the inputs from our quantities."""
        self._write(self._inward(values))

    def read(self) -> Sequence[float]:
        """Our quantities from the outputs; raises FmuError if one that must be finite is not."""
        values = self._outward(self._read())
        if self.foreign and not all(map(math.isfinite, values)):
            pairs = zip(self.targets, values, strict=True)
            lost = (f"{name} = {value}" for name, value in pairs if not math.isfinite(value))
            raise self.slave.failure(f"its outputs, which give {', '.join(lost)}")
        return values

    def step(self, t: float, h: float) -> None:
        """Make one step, or several of the FMU's own size."""
        deque(self.steps(t, h, t + h), maxlen=0)

    def steps(self, t: float, h: float, end: float) -> Iterator[float]:
        """Step as `step` does, and yield the time after each FMU step; the last is ``end``."""
        count = 1 if self.step_size is None else max(1, round(h / self.step_size))
        for i in range(count):
            self.slave.step(t + i * (h / count), h / count)
            yield t + (i + 1) * (h / count) if i + 1 < count else end


class GuardedController:
    """A controller followed by the velocity guard, as one part; see `Part`.

    Both sample at the same instant: the guard receives the controller's force and the same
    velocity, and this part's torques are the guard's.  So the loop equals that of a controller with
    a built-in guard, under either master.
    """

    foreign = False

    def __init__(self, controller: Part, guard: Part) -> None:
        """Combine both; ``controller`` outputs its force first, then its diagnostics."""
        self.controller, self.guard = controller, guard
        self.wants_ready = controller.wants_ready
        own = controller.targets[_ASKED:]
        self._own = [_ASKED + i for i, name in enumerate(own) if name not in guard.targets]
        self.targets = (*guard.targets, *(controller.targets[i] for i in self._own))
        self._shown: tuple[float, ...] = ()
        self._asked: Sequence[float] = ()
        self._told: list[float] = []

    def write(self, values: Sequence[float]) -> None:
        """Set the controller's inputs; the guard receives the same velocity."""
        self.controller.write(values)
        self._shown = tuple(values[i] for i in _SHOWN)

    def step(self, t: float, h: float) -> None:
        """Step the controller, then the guard with the controller's force."""
        self.controller.step(t, h)
        given = self.controller.read()
        self._told = [given[i] for i in self._own]
        self._asked = given[:_ASKED]
        self.guard.write((*self._asked, *self._shown))
        self.guard.step(t, h)

    def read(self) -> Sequence[float]:
        """Torques and diagnostics of the guard, then those of the controller."""
        return [*self.guard.read(), *self._told]


class FilteredController(GuardedController):
    """A controller followed by the command filter, in the guard's place."""

    def __init__(self, controller: Part, guard: Part) -> None:
        """Combine both; ``controller`` outputs its velocity first."""
        super().__init__(controller, guard)
        told = elements(FILTERING)
        self._own = [i for i in self._own if controller.targets[i] not in told]
        own = (controller.targets[i] for i in self._own)
        self.targets = (*mapping.COMMANDED, *told, *own)

    def read(self) -> Sequence[float]:
        """Velocity sent, diagnostics of the filter, then those of the controller."""
        *sent, flags = self.guard.read()
        changed = (float(one != other) for one, other in zip(sent, self._asked, strict=True))
        agrees = float(not int(flags) & BOUNDS_LEFT)
        return [*sent, *changed, 0.0, 0.0, agrees, *self._asked, flags, *self._told]


def own_part(
    slave: Slave, sources: Sequence[str], outputs: Sequence[str], more: Sequence[str] = ()
) -> Part:
    """One of our FMUs, by its own names: inputs among ``sources``, and ``outputs``.

    ``more``: outputs that are read if they exist.
    """
    known = slave.variables
    missing = [name for name in outputs if name not in known]
    if missing:
        raise ArgumentError(
            f"the FMU {slave.path} ({slave.name}) has no {', '.join(missing)}. If it is not one of "
            "ours, give a map of its names and units (--map FILE.toml)."
        )
    inputs = [name for name in sources if name in known and known[name].causality == "input"]
    shown = (*outputs, *(name for name in more if name in known))
    return Part(slave, mapping.identity(inputs), mapping.identity(shown), sources)


def controller_part(
    slave: Slave,
    part: mapping.PartMap | None,
    robot: Robot,
    diagnostics: Sequence[str],
    asked: Sequence[str] = mapping.TORQUES,
) -> Part:
    """Our controller, by its own names, or one with a map; diagnostics are read if they exist.

    ``asked``: its outputs: the torques of both wheels, for a guard the force, or the velocity.
    """
    if part is None:
        return own_part(slave, mapping.SEEN, asked, diagnostics)
    theirs = mapping.input_rows(part, slave.unit, "controller")
    given = mapping.controller_outputs(part, slave.unit, robot, asked)
    return Part(slave, theirs, given, mapping.SEEN, part.step, foreign=True)


def plant_part(
    slave: Slave, part: mapping.PartMap | None, robot: Robot, rolling: Sequence[Signal] = ()
) -> Part:
    """Our plant, by its own names, or one with a map; it may output psi and wheel speeds instead.

    ``rolling``: further outputs that sensors need, PATH and SKID; a missing skid is zero.
    """
    if part is None:
        shown = (*mapping.STATE, *(item.name for item in rolling[:1]))
        return own_part(slave, mapping.DRIVEN, shown)
    theirs = mapping.input_rows(part, slave.unit, "plant")
    given = mapping.plant_outputs(part, slave.unit, robot, rolling)
    return Part(slave, theirs, given, mapping.DRIVEN, part.step, foreign=True)


def ready(state: Sequence[float], robot: Robot) -> tuple[float, float, float]:
    """psi [rad] and wheel speeds (right, left) [rad/s] from a state."""
    return state[2] + math.pi / 2, *wheels_of(state[3:], robot)


def wheels_of(velocity: Sequence[float], robot: Robot) -> tuple[float, float]:
    """Speeds of the wheels (right, left) [rad/s] at a velocity [m/s, rad/s]."""
    v1, omega = velocity
    turn = robot.l * omega
    return (v1 + turn) / robot.r, (v1 - turn) / robot.r


@cache
def limiter() -> ca.Function:
    """Function from torques (right, left) [N m], r, l [m] and tau_max to limited torques.

    The thrust has priority.
    """
    torque, r, half_track, most = (
        ca.SX.sym(n, k) for n, k in (("tau", 2), ("r", 1), ("l", 1), ("m", 1))
    )
    force = wheel_to_force(r, half_track, torque)
    within = linear_first(force, full_thrust(r, most), half_track)
    outside = ca.logic_or(within[0] != force[0], within[1] != force[1])
    limited = ca.if_else(outside, force_to_wheel(r, half_track, within), torque)
    return ca.Function("limited", [torque, r, half_track, most], [limited])
