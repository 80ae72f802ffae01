"""The three parts of a co-simulation: reference, controller and plant, in our names and units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache

import casadi as ca
import numpy as np

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.fmi.cosim.mapping import MapRow, PartMap, compiled, identity, input_rows, output_rows
from wmr_ctrl.fmi.cosim.slave import FmuFile, Slave
from wmr_ctrl.guard.guard import linear_first
from wmr_ctrl.model.dynamics import force_to_wheel, wheel_to_force
from wmr_ctrl.scenario import Robot, Scenario
from wmr_ctrl.signals import (
    BODY_FORCE,
    FORCE,
    GUARD_DIAGNOSTICS,
    PATH,
    PLANT_STATE,
    REFERENCE,
    SKID,
    TAU_APPLIED,
    TORQUE,
    TORQUE_NOISE,
    VELOCITY,
    Signal,
)

STATE = tuple(s.name for s in PLANT_STATE)
DESIRED = tuple(s.name for s in REFERENCE)
TORQUES = tuple(s.name for s in TORQUE)
NOISES = tuple(s.name for s in TORQUE_NOISE)
PUSHED = tuple(s.name for s in BODY_FORCE)
APPLIED = TAU_APPLIED.elements
UNITS = {
    **{s.name: s.unit for s in (*PLANT_STATE, *REFERENCE, *TORQUE, *TORQUE_NOISE, *BODY_FORCE)},
    **{s.name: s.unit for s in (PATH, SKID)},
    **dict.fromkeys((*APPLIED, "torque_right", "torque_left"), "N.m"),
    **dict(zip(FORCE.elements, FORCE.units, strict=True)),
    "psi": "rad",
    "w_right": "rad/s",
    "w_left": "rad/s",
}
"""Ours, with the ready ones: psi, the wheels' speeds, torques with the disturbance in them, and the
force (thrust, moment) in the place of both torques."""
READY = ("psi", "w_right", "w_left")
GUARDED = (*FORCE.elements, *(s.name for s in VELOCITY))
"""What a guard is shown."""
DRIVEN = (*TORQUES, *NOISES, *PUSHED, "torque_right", "torque_left")
_INSTEAD = {"plant": READY, "controller": FORCE.elements}
SEEN = (*DESIRED, *STATE, *APPLIED, *READY)


class Part:
    """An FMU with the maps of its inputs and outputs.

    ``write`` takes the values of ``sources``; ``read`` gives those of ``targets``; ``uses`` are the
    sources that the inputs are made of; ``foreign``: somebody else's, described by a map;
    ``strict``: what is read must be finite.
    """

    def __init__(
        self,
        slave: Slave,
        inputs: Sequence[MapRow],
        outputs: Sequence[MapRow],
        sources: Sequence[str],
        step: float | None = None,
        *,
        foreign: bool = False,
        strict: bool = False,
    ) -> None:
        self.slave, self.targets, self.step_size = slave, tuple(row.target for row in outputs), step
        self.foreign, self._strict = foreign, strict
        theirs = list(dict.fromkeys(name for row in outputs for name, _ in row.terms))
        self.uses = frozenset(name for row in inputs for name, _ in row.terms)
        self.wants_ready = not self.uses.isdisjoint(READY)
        self._inward = compiled(inputs, sources) if inputs else None
        self._write = slave.writer([row.target for row in inputs])
        self._read, self._outward = slave.reader(theirs), compiled(outputs, theirs)
        self._same = all(row.plain for row in outputs) and theirs == [
            row.terms[0][0] for row in outputs
        ]

    def write(self, values: Sequence[float]) -> None:
        """Set the inputs from our quantities."""
        if self._inward is not None:
            self._write(self._inward(values))

    def read(self) -> Sequence[float]:
        """Our quantities from the outputs; raises FmuError where one must be finite and is not."""
        values = self._read() if self._same else self._outward(self._read())
        if self._strict and not all(map(math.isfinite, values)):
            pairs = zip(self.targets, values, strict=True)
            lost = (f"{name} = {value}" for name, value in pairs if not math.isfinite(value))
            raise self.slave.failure(f"its outputs, which give {', '.join(lost)}")
        return values

    def step(self, t: float, h: float) -> None:
        """One step, or several of the FMU's own size."""
        for _ in self.steps(t, h, t + h):
            continue

    def steps(self, t: float, h: float, end: float) -> Iterator[float]:
        """The same, stopping after each with the time that was reached; the last is ``end``."""
        count = 1 if self.step_size is None else max(1, round(h / self.step_size))
        for i in range(1, count):
            self.slave.step(t + (i - 1) * (h / count), h / count)
            yield t + i * (h / count)
        self.slave.step(t + (count - 1) * (h / count), h / count)
        yield end


def reference_part(slave: Slave) -> Part:
    """Our reference FMU."""
    return Part(slave, [], identity(DESIRED), ())


def controller_part(
    slave: Slave,
    part: PartMap | None,
    robot: Robot,
    diagnostics: Sequence[str],
    asked: Sequence[str] = TORQUES,
) -> Part:
    """Ours, by its own names, or one with a map; the diagnostics are read where they exist.

    ``asked``: what it gives, the torques of both wheels or, for a guard, the force.
    """
    if part is None:
        known = [
            name
            for name in SEEN
            if name in slave.variables and slave.variables[name].causality == "input"
        ]
        outputs = (*asked, *(name for name in diagnostics if name in slave.variables))
        _need(slave, outputs[:2])
        return Part(slave, identity(known), identity(outputs), SEEN)
    return Part(
        slave,
        input_rows(part.inputs, UNITS, slave.unit, "controller", si=part.si),
        controller_outputs(slave, part, robot, asked),
        SEEN,
        part.step,
        foreign=True,
        strict=True,
    )


def guard_part(slave: Slave) -> Part:
    """Our guard FMU."""
    shown = (*TORQUES, *(name for item in GUARD_DIAGNOSTICS for name in item.elements))
    return Part(slave, identity(GUARDED), identity(shown), GUARDED)


def plant_part(
    slave: Slave, part: PartMap | None, robot: Robot, rolling: Sequence[Signal] = ()
) -> Part:
    """Ours, by its own names, or one with a map; pose and velocity may come from ready names.

    ``rolling``: what sensors ask beside the state, PATH and SKID; without the latter it is zero.
    """
    shown = (*STATE, *(item.name for item in rolling[:1]))
    if part is None:
        _need(slave, (*shown, *TORQUES))
        inputs = [name for name in (*TORQUES, *NOISES, *PUSHED) if name in slave.variables]
        return Part(slave, identity(inputs), identity(shown), DRIVEN)
    return Part(
        slave,
        input_rows(part.inputs, UNITS, slave.unit, "plant", si=part.si),
        plant_outputs(slave, part, robot, rolling),
        DRIVEN,
        part.step,
        foreign=True,
    )


def controller_outputs(
    file: FmuFile, part: PartMap, robot: Robot, asked: Sequence[str] = TORQUES
) -> list[MapRow]:
    """Rows that give what is ``asked``, torques or the force, from a foreign controller's outputs.

    Each follows from the other: thrust and moment are those of the torques at robot.r and robot.l.
    """
    rows = output_rows(part.outputs, UNITS, file.unit, "controller", si=part.si)
    by_target = {row.target: row for row in rows}
    given = TORQUES if FORCE.elements[0] not in by_target else FORCE.elements
    _complete(rows, given, "controller")
    first, second = (by_target[name] for name in given)
    if tuple(asked) == tuple(given):
        return [first, second]
    r, half_track = robot.r, robot.l
    if given == TORQUES:
        sums, differences = (1 / r, 1 / r), (half_track / r, -half_track / r)
    else:
        sums, differences = (r / 2, r / 2 / half_track), (r / 2, -r / 2 / half_track)
    shares = zip(asked, (sums, differences), strict=True)
    return [_combined(name, {first: a, second: b}) for name, (a, b) in shares]


def plant_outputs(
    file: FmuFile, part: PartMap, robot: Robot, rolling: Sequence[Signal] = ()
) -> list[MapRow]:
    """Rows that give pose and velocity from a foreign plant's outputs, and the wheels' way.

    Raises ArgumentError where one is missing; without a row for the skid it is zero.
    """
    rows = _without_ready(output_rows(part.outputs, UNITS, file.unit, "plant", si=part.si), robot)
    _complete(rows, STATE, "plant")
    given = {row.target for row in rows}
    if rolling and PATH.name not in given:
        raise ArgumentError(
            f"a sensor of the scenario counts the way that the wheels roll, and the map's "
            f"[plant.outputs] does not give {PATH.name}. Add a row for it [m] (and one for "
            f"{SKID.name} [rad] if the wheels slip), or leave that sensor out."
        )
    further = [item.name for item in rolling if item.name in given]
    return _sorted(rows, (*STATE, *further))


def ready(state: Sequence[float], robot: Robot) -> tuple[float, float, float]:
    """psi [rad] and the wheels' speeds (right, left) [rad/s] of a state."""
    _, _, theta, v1, omega = state
    turn = robot.l * omega
    return theta + math.pi / 2, (v1 + turn) / robot.r, (v1 - turn) / robot.r


@cache
def limiter() -> ca.Function:
    """Torques (right, left) [N m], r, l [m] and tau_max to torques within it, the thrust first."""
    torque, r, half_track, most = (
        ca.SX.sym(n, k) for n, k in (("tau", 2), ("r", 1), ("l", 1), ("m", 1))
    )
    force = wheel_to_force(r, half_track, torque)
    within = linear_first(force, 2 * most / r, half_track)
    outside = ca.logic_or(within[0] != force[0], within[1] != force[1])
    limited = ca.if_else(outside, force_to_wheel(r, half_track, within), torque)
    return ca.Function("limited", [torque, r, half_track, most], [limited])


def limited_torque(torque: tuple[float, float], scenario: Scenario) -> Sequence[float]:
    """Torques (right, left) [N m] within actuator.tau_max, the thrust served first."""
    robot = scenario.robot
    limited = limiter()(torque, robot.r, robot.l, scenario.actuator.tau_max)
    return np.asarray(limited).ravel().tolist()


def _without_ready(rows: Sequence[MapRow], robot: Robot) -> list[MapRow]:
    """theta from psi, v1 and omega from the wheels' speeds, where these are mapped."""
    by_target = {row.target: row for row in rows}
    if "psi" in by_target:
        psi = by_target.pop("psi")
        by_target["theta"] = MapRow("theta", psi.terms, psi.offset - math.pi / 2)
    if {"w_right", "w_left"} <= by_target.keys():
        right, left = by_target.pop("w_right"), by_target.pop("w_left")
        by_target["v1"] = _combined("v1", {right: robot.r / 2, left: robot.r / 2})
        by_target["omega"] = _combined(
            "omega", {right: robot.r / (2 * robot.l), left: -robot.r / (2 * robot.l)}
        )
    return list(by_target.values())


def _combined(target: str, parts: Mapping[MapRow, float]) -> MapRow:
    terms = tuple(
        (name, share * factor) for row, share in parts.items() for name, factor in row.terms
    )
    return MapRow(target, terms, sum(share * row.offset for row, share in parts.items()))


def _sorted(rows: Sequence[MapRow], order: Sequence[str]) -> list[MapRow]:
    return [next(row for row in rows if row.target == name) for name in order]


def _complete(rows: Sequence[MapRow], wanted: Sequence[str], part: str) -> None:
    missing = sorted(set(wanted) - {row.target for row in rows})
    if missing:
        raise ArgumentError(
            f"the map's [{part}.outputs] does not give {', '.join(missing)}. Add a row for each, "
            f"or for the ready names {', '.join(_INSTEAD[part])} that they follow from."
        )


def _need(slave: Slave, names: Sequence[str]) -> None:
    missing = [name for name in names if name not in slave.variables]
    if missing:
        raise ArgumentError(
            f"the FMU {slave.path} ({slave.name}) has no {', '.join(missing)}. If it is not one of "
            "ours, give a map of its names and units (--map FILE.toml)."
        )
