"""Maps between our names and units and those of a foreign FMU, from a TOML file.

A row says ``target = sum of coefficient times source, plus offset``.  Rows of ``outputs`` have our
names on the left, rows of ``inputs`` theirs.  A plain string is a renaming; units are converted::

    [plant]
    step = 0.002                       # communication step of the FMU, s
    units = "SI"                       # of variables that state none; left out, each row states it
    [plant.inputs]
    motorR = "torque_right"
    enable = true                      # a constant: { offset = 1 }
    [plant.outputs]
    x = "position[1]"                  # an array's element
    psi = { terms = { heading = 1.0 }, unit = "deg" }
    w_right = { terms = { wheelR = 1.0 }, unit = "rpm" }
    w_left = { terms = { wheelL = 1.0 }, unit = "rpm" }
    [plant.parameters]                 # for scenarios that change them; tunable, one for each
    "robot.m" = { terms = { grams = 1.0 }, unit = "g" }
"""

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError, show
from wmr_ctrl.core.fields.files import parse_toml, read_text
from wmr_ctrl.core.fields.named_units import NamedUnit, unit_of
from wmr_ctrl.core.fields.section import Section, build, quantities, quantity
from wmr_ctrl.core.fields.values import Frozen
from wmr_ctrl.core.signals import (
    BODY_FORCE,
    COMMAND,
    FORCE,
    ODOMETRY_AGE,
    PATH,
    PLANT_STATE,
    REFERENCE,
    SKID,
    TAU_APPLIED,
    TORQUE,
    TORQUE_NOISE,
    Signal,
)
from wmr_ctrl.world.scenario import Change, Robot
from wmr_ctrl.world.scenario.toml_io import naming_file

STATE = tuple(s.name for s in PLANT_STATE)
TORQUES = tuple(s.name for s in TORQUE)
SPEEDS = STATE[3:]
READY = ("psi", "w_right", "w_left")
"""Usual heading and speeds of the wheels, from which theta, v1 and omega follow."""
DISTURBED = ("torque_right", "torque_left")
"""Torques with the disturbance in them."""
COMMANDED = tuple(s.name for s in COMMAND)
WHEELS = ("w_right_command", "w_left_command")
"""Velocities that a base takes, and speeds of its wheels that are the same."""
CHANGED = {f"robot.{name}": what.unit for name, what in quantities(Change) if name != "t"}
"""Units of what a scenario may change of a plant, by its key."""
UNITS = {
    **CHANGED,
    **{s.name: s.unit for s in (*PLANT_STATE, *REFERENCE, *TORQUE, *TORQUE_NOISE, *BODY_FORCE)},
    **{s.name: s.unit for s in (PATH, SKID)},
    **dict.fromkeys((*TAU_APPLIED.elements, *DISTURBED), "N.m"),
    **dict(zip(FORCE.elements, FORCE.units, strict=True)),
    **dict(zip(READY, ("rad", "rad/s", "rad/s"), strict=True)),
    **{s.name: s.unit for s in (*COMMAND, ODOMETRY_AGE)},
    **dict.fromkeys(WHEELS, "rad/s"),
}
"""Units of our quantities; the force (thrust, moment) may stand in the place of both torques."""
UnitOf = Callable[[str], NamedUnit | str | None]
"""From the name of their variable to its unit: as the FMU defines it, its mere name, or nothing."""
DESIRED = tuple(s.name for s in REFERENCE)
NOISES = tuple(s.name for s in TORQUE_NOISE)
DRIVEN = (*TORQUES, *NOISES, *(s.name for s in BODY_FORCE), *DISTURBED, *COMMANDED, *WHEELS)
"""Sources of a plant."""
SEEN = (*DESIRED, *STATE, *TAU_APPLIED.elements, ODOMETRY_AGE.name, *READY)
"""Sources of a controller."""
TAKEN = {"plant": DRIVEN, "controller": SEEN}
"""Our quantities from which inputs of each part may be computed."""
GIVEN = {
    "plant": (*STATE, *READY, PATH.name, SKID.name),
    "controller": (*TORQUES, *FORCE.elements, *COMMANDED, *WHEELS),
}
"""Quantities of ours that outputs of each part may give."""
EITHER = {
    "plant": ((("theta",), ("psi",)), (("v1", "omega"), ("w_right", "w_left"))),
    "controller": ((TORQUES, FORCE.elements), (COMMANDED, WHEELS)),
}
"""Outputs of which a map gives the one or the other."""
_PARAMETERS = "plant.parameters"
_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True)
class MapRow:
    """target = sum of coefficient * source + offset, each in its owner's unit."""

    target: str
    terms: tuple[tuple[str, float], ...]
    offset: float = 0.0


def _table(doc: str, kind: str = "mapping") -> Any:
    return quantity(Frozen(), "", doc, kind=kind)


class PartMap(Section):
    """The map of one FMU, as read: raw rows, parameters by our key, start values, step."""

    inputs: Mapping[str, object] = _table("row of each input of the FMU")
    outputs: Mapping[str, object] = _table("row of each quantity of ours")
    parameters: Mapping[str, object] = _table("row of each key that a scenario changes")
    start: Mapping[str, object] = _table("start values of the FMU")
    step: float | None = quantity(None, "s", "communication step of the FMU", above=0)
    units: str = quantity(
        "stated",
        "1",
        "units of variables for which the FMU gives none: stated in their rows, or SI",
        options=("stated", "SI"),
    )


class MapEntry(Section):
    """A row as a table: target = sum of coefficient * source + offset."""

    terms: Mapping[str, float] = quantity(
        Frozen(), "1", "coefficient of each source", kind="numbers"
    )
    offset: float = quantity(0.0, "1", "what is added, in the target's unit")
    unit: str = quantity("", "1", "unit of the FMU's variables")
    coefficient_unit: str = quantity("1", "1", "unit of the coefficients")


def load_map(path: str | Path) -> dict[str, PartMap]:
    """Read a map file: parts ``plant`` and ``controller``; raises ArgumentError naming the key."""
    raw = parse_toml(read_text(Path(path), "map"), Path(path))
    for part in raw:
        if part not in ("plant", "controller"):
            raise UnknownNameError(f"part of the map {path}", part, ("plant", "controller"))
    with naming_file(path):
        maps = {part: build(PartMap, table, part) for part, table in raw.items()}
    if "controller" in maps and maps["controller"].parameters:
        raise ArgumentError(
            f"[controller.parameters] of the map {path} has no effect: scenarios change a plant "
            "alone. State what the controller begins with in [controller.start]."
        )
    return maps


def identity(names: Sequence[str]) -> list[MapRow]:
    """Rows for an FMU with our names and units."""
    return [MapRow(name, ((name, 1.0),)) for name in names]


def compiled(
    rows: Sequence[MapRow], sources: Sequence[str]
) -> Callable[[Sequence[float]], Sequence[float]]:
    """A function from the values of ``sources`` to those of the rows' targets."""
    place = {name: i for i, name in enumerate(sources)}
    table = [([(place[name], factor) for name, factor in row.terms], row.offset) for row in rows]
    return lambda values: [
        sum(values[i] * factor for i, factor in terms) + offset for terms, offset in table
    ]


def input_rows(part: PartMap, theirs: UnitOf, name: str) -> list[MapRow]:
    """Rows for the inputs of a foreign FMU; ``theirs``: units of its variables, ``name``: its
    name.
    """
    given = part.inputs.items()
    return [_Row(f"{name}.inputs", *row, theirs, part.units, inward=True).read() for row in given]


def output_rows(part: PartMap, theirs: UnitOf, name: str) -> list[MapRow]:
    """Rows that compute our quantities from a foreign FMU's outputs."""
    given = part.outputs.items()
    for one, other in EITHER[name]:
        both = [next((key for key in side if key in part.outputs), "") for side in (one, other)]
        if all(both):
            raise ArgumentError(
                f"the map's [{name}.outputs] gives both {' and '.join(both)}, of which one has no "
                f"effect. Give either {', '.join(one)} or {', '.join(other)}."
            )
    return [_Row(f"{name}.outputs", *row, theirs, part.units, inward=False).read() for row in given]


def parameter_rows(part: PartMap, theirs: UnitOf) -> dict[str, MapRow]:
    """Rows for the numbers that a scenario changes, each one parameter of a foreign FMU, by our
    key.
    """
    given = part.parameters.items()
    rows = [_Row(_PARAMETERS, *row, theirs, part.units, inward=False).read() for row in given]
    for row in rows:
        if len(row.terms) != 1 or row.terms[0][1] == 0.0:
            raise ArgumentError(
                f"{_PARAMETERS}.{row.target} must be of one parameter of the FMU, with a "
                "coefficient other than 0, since it is set to what the scenario says."
            )
    return {row.target: row for row in rows}


class _Row:
    """Reader of one row; ``inward``: it computes one of a foreign FMU's inputs from our
    quantities.
    """

    def __init__(
        self, table: str, target: str, raw: object, theirs: UnitOf, units: str, *, inward: bool
    ) -> None:
        self.key = key = f"{table}.{target}"
        self.target, self.theirs, self.units = target, theirs, units
        sides = TAKEN if inward else GIVEN
        self.ours = tuple(CHANGED) if table == _PARAMETERS else sides[table.partition(".")[0]]
        if not isinstance(raw, str | float | int | Mapping):
            raise ArgumentError(
                f"{key} = {show(raw)} must be a name, a constant, or a table with terms."
            )
        if not isinstance(raw, Mapping):
            raw = {"terms": {raw: 1.0}} if isinstance(raw, str) else {"offset": float(raw)}
        self.entry = build(MapEntry, raw, key)
        if not self.entry.terms and "offset" not in raw:
            raise ArgumentError(f"{key}: no terms. Name a source, or state the constant as offset.")
        ours = [name for name in (self.entry.terms if inward else [target]) if name in UNITS]
        self.fitting = UNITS[ours[0]] if ours else "1"
        self.unit_of_target = self.unit_of_theirs if inward else self.unit_of_ours
        self.unit_of_source = self.unit_of_ours if inward else self.unit_of_theirs

    def read(self) -> MapRow:
        """The row in the owners' units; units with an offset are converted through SI."""
        entry, factor_unit = self.entry, unit_of(self.entry.coefficient_unit)
        wanted = self.unit_of_target(self.target)
        shares, start = [], -wanted.offset
        for name, factor in entry.terms.items():
            given = self.unit_of_source(name)
            if not (given * factor_unit).fits(wanted):
                named = factor_unit.name
                unit = "" if named == "1" else f" with a coefficient in {named}"
                raise ArgumentError(
                    f"{self.key}: {name} in {given.name} does not give {wanted.name}{unit}. Give "
                    "the coefficient's unit as coefficient_unit, or map another variable."
                )
            share = factor * factor_unit.factor
            shares.append((name, share * given.factor / wanted.factor))
            start += share * given.offset
        return MapRow(self.target, tuple(shares), entry.offset + start / wanted.factor)

    def unit_of_ours(self, name: str) -> NamedUnit:
        """Unit of one of our quantities."""
        if name not in self.ours:
            raise UnknownNameError(f"quantity of ours that {self.key} can have", name, self.ours)
        return unit_of(UNITS[name])

    def unit_of_theirs(self, name: str) -> NamedUnit:
        """Unit of one of a foreign FMU's variables: from the row, else from that FMU."""
        si = self.fitting if self.units == "SI" or self.fitting == "1" else None
        unit = self.entry.unit or self.theirs(name) or si
        if isinstance(unit, NamedUnit):
            return unit
        terms = ", ".join(f"{toml_key(k)} = {share!r}" for k, share in self.entry.terms.items())
        hint = (
            f"State it in the row, such as: {toml_key(self.target)} = {{ terms = {{ {terms} }}, "
            f'unit = "{self.fitting}" }}'
        )
        if unit is None:
            part = self.key.partition(".")[0]
            raise ArgumentError(
                f"{self.key}: the FMU gives no unit for {name}. {hint}; or, where all of its "
                f'variables without a unit are in SI units, write units = "SI" in [{part}].'
            )
        try:
            return unit_of(unit)
        except ArgumentError as error:
            raise ArgumentError(
                f"{self.key}: {name} has the unit {unit!r}, which the FMU does not define, and "
                f"{error} {hint}."
            ) from error


def toml_key(name: str) -> str:
    """A name as a TOML key, quoted if necessary."""
    return name if _BARE.fullmatch(name) else json.dumps(name)


def controller_outputs(
    part: PartMap, theirs: UnitOf, robot: Robot, asked: Sequence[str] = TORQUES
) -> list[MapRow]:
    """Rows that compute the quantities ``asked`` from a foreign controller's outputs.

    ``asked``: torques, the force, or the velocity for a base that takes one.  Torques and force can
    be computed from each other, a velocity from the wheels' speeds, with robot.r and robot.l.
    """
    by_target = {row.target: row for row in output_rows(part, theirs, "controller")}
    instead = _follow(by_target, asked, robot)
    _check_complete(by_target, asked, "controller", instead)
    return [by_target[name] for name in asked]


def plant_outputs(
    part: PartMap, theirs: UnitOf, robot: Robot, rolling: Sequence[Signal] = ()
) -> list[MapRow]:
    """Rows that compute pose, velocity and the wheels' path length from a foreign plant's outputs.

    theta may be computed from psi, v1 and omega from the wheels' speeds.  Raises ArgumentError if
    one is missing; without a row for the skid it is zero.
    """
    by_target = {row.target: row for row in output_rows(part, theirs, "plant")}
    if "psi" in by_target:
        psi = by_target.pop("psi")
        by_target["theta"] = MapRow("theta", psi.terms, psi.offset - math.pi / 2)
    _follow(by_target, SPEEDS, robot)
    _check_complete(by_target, STATE, "plant", READY)
    if rolling and PATH.name not in by_target:
        raise ArgumentError(
            f"a sensor of the scenario measures the distance that the wheels roll, and the map's "
            f"[plant.outputs] does not give {PATH.name}. Add a row for it [m] (and one for "
            f"{SKID.name} [rad] if the wheels slip), or leave that sensor out."
        )
    further = [item.name for item in rolling if item.name in by_target]
    return [by_target[name] for name in (*STATE, *further)]


def _follow(rows: dict[str, MapRow], wanted: Sequence[str], robot: Robot) -> Sequence[str]:
    """Add the two rows that are ``wanted`` if the rows to compute them from exist.

    Returns the names of the latter.
    """
    r, half_track = robot.r, robot.l
    halves = (r / 2, r / 2), (r / 2 / half_track, -r / 2 / half_track)
    ways: Mapping[Sequence[str], tuple[Sequence[str], Sequence[tuple[float, float]]]] = {
        SPEEDS: (READY[1:], halves),
        COMMANDED: (WHEELS, halves),
        TORQUES: (FORCE.elements, ((halves[0][0], halves[1][0]), (halves[0][0], halves[1][1]))),
        FORCE.elements: (TORQUES, ((1 / r, 1 / r), (half_track / r, -half_track / r))),
    }
    instead, shares = ways[wanted]
    if rows.keys().isdisjoint(wanted) and rows.keys() >= {*instead}:
        first, second = (rows[name] for name in instead)
        for name, (a, b) in zip(wanted, shares, strict=True):
            rows[name] = _combined(name, {first: a, second: b})
    return instead


def _combined(target: str, parts: Mapping[MapRow, float]) -> MapRow:
    terms = tuple(
        (name, share * factor) for row, share in parts.items() for name, factor in row.terms
    )
    return MapRow(target, terms, sum(share * row.offset for row, share in parts.items()))


def _check_complete(
    rows: Mapping[str, MapRow], wanted: Sequence[str], part: str, instead: Sequence[str]
) -> None:
    missing = sorted(set(wanted) - rows.keys())
    if missing:
        raise ArgumentError(
            f"the map's [{part}.outputs] does not give {', '.join(missing)}. Add a row for each, "
            f"or for the ready names {', '.join(instead)} from which they follow."
        )
