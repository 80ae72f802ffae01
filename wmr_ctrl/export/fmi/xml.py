"""modelDescription.xml and its companions: the values that the templates print."""

import math
from collections.abc import Iterable
from typing import Any

from wmr_ctrl.codegen.package import FILTER
from wmr_ctrl.control.filter.channels import SENT
from wmr_ctrl.control.filter.governor_step import ODOMETRY
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.named_units import NamedUnit, unit_of, units_of
from wmr_ctrl.core.signals import ASKED, POSE, REFERENCE, TORQUE, TORQUE_NOISE, VELOCITY

from .files import Sources, render, row_size
from .model_description import FmuModel, Role, Variable

Attributes = list[tuple[str, str]]
TERMINALS = (
    ("reference", "the desired trajectory", REFERENCE),
    ("pose", "position and orientation", POSE),
    ("velocity", "linear and angular velocity", VELOCITY),
    ("torque", "wheel torques", TORQUE),
    ("asked", "velocity asked for", (ASKED,)),
    ("odometry", "velocity that odometry tells", (ODOMETRY,)),
    ("command", "velocity command that is safe", (SENT,)),
    ("disturbance", "disturbance torques on the wheels", TORQUE_NOISE),
)
_GIVEN = {Role.INDEPENDENT: "independent", Role.INPUT: "input"}
SECTIONS = {
    2: ("Outputs", "Derivatives", "InitialUnknowns"),
    3: ("Output", "ContinuousStateDerivative", "InitialUnknown"),
}
"""Names of ModelStructure's sections, by version of FMI."""


def description(
    model: FmuModel,
    sources: Sources,
    version: int,
    tool: str,
    *,
    arrays: bool = True,
    note: str = "",
) -> str:
    """Text of modelDescription.xml for FMI 2 or 3; ``note``: what it says after the title."""
    arrays = arrays and version == 3
    rows = [(i, v) for i, v in enumerate(model.variables) if row_size(v, arrays)]
    clock = model.scenario.clock
    shown = {
        "identifier": model.identifier,
        "token": sources.token,
        "title": model.title + note,
        "tool": tool,
        "version": tool.rpartition(" ")[2],
        "license": "BSD-3-Clause",
        "units": sources.units,
        "unit_definitions": _units(model.variables),
        "duration": repr(clock.duration),
        "step": repr(clock.control),
        "internal_step": repr(clock.plant if model.kind == "continuous" else clock.control),
        "derivatives": bool(model.derivatives),
        "model_exchange": bool(model.layout["HAS_ME"]),
    }
    shown["structure"] = _structure(model, version, arrays)
    shown["variables"] = [_variable(model, i, v, version, arrays) for i, v in rows]
    return render(f"fmi{version}.xml", m=shown)


def terminals(model: FmuModel) -> str:
    """Text of terminalsAndIcons/terminalsAndIcons.xml, FMI 3."""
    ports = {v.name for v in model.variables if v.output or v.role is Role.INPUT}
    listed = [
        {"name": name, "text": text, "members": [name for s in signals for name in s.elements]}
        for name, text, signals in TERMINALS
        if ports.issuperset(name for s in signals for name in s.elements)
    ]
    return render("terminalsAndIcons.xml", m={"terminals": listed})


def documentation(model: FmuModel, tool: str) -> str:
    """Text of documentation/index.html."""
    rows = [
        (v, _causality(v), "" if _start(v) is None else f"{v.start:.6g}") for v in model.variables
    ]
    named = {"identifier": model.identifier, "title": model.title, "tool": tool}
    packed = model.what in (*LAWS, FILTER)
    kinds = {"scenario": model.scenario.name, "kind": model.kind, "packed": packed}
    return render("index.html", m={**named, **kinds, "documented": rows})


def _units(variables: Iterable[Variable]) -> list[NamedUnit]:
    """The different units; ArgumentError, which names the variable, for what is none."""
    listed = list(variables)
    for item in listed:
        try:
            unit_of(item.unit)
        except ArgumentError as error:
            raise ArgumentError(f"{item.name}: {error}") from None
    return units_of(item.unit for item in listed)


def _causality(v: Variable) -> str:
    if v.parameter:
        return "parameter"
    return _GIVEN.get(v.role, "output" if v.output else "local")


def _head(v: Variable, row: int, name: str, meaning: str) -> Attributes:
    """Attributes that a variable of either version begins with."""
    variability = "discrete" if v.discrete else "continuous"
    if v.parameter:
        variability = "fixed" if v.role is Role.FIXED else "tunable"
    initial = "calculated" if v.role is Role.CALCULATED else "exact"
    return [
        ("name", name),
        ("valueReference", str(row)),
        ("description", meaning),
        ("causality", _causality(v)),
        ("variability", variability),
        *([] if v.role in _GIVEN else [("initial", initial)]),
    ]


def _start(v: Variable) -> str | None:
    if v.role in (Role.INDEPENDENT, Role.CALCULATED):
        return None
    return str(int(v.start)) if v.integer else repr(v.start)


def _typed(model: FmuModel, v: Variable) -> Attributes:
    """Attributes that belong to the value: unit, display unit, range, nominal."""
    ends = [(key, end) for key, end in (("min", v.low), ("max", v.high)) if math.isfinite(end)]
    if v.integer:
        return [(key, str(int(end))) for key, end in ends]
    display = unit_of(v.unit).display
    nominal = model.kind == "continuous" and v.role is Role.START
    return [
        ("unit", v.unit),
        *([("displayUnit", display[0])] if display else []),
        *((key, repr(end)) for key, end in ends),
        *([("nominal", "1.0")] if nominal else []),
    ]


def _variable(model: FmuModel, row: int, v: Variable, version: int, arrays: bool) -> dict[str, Any]:
    size, whole = row_size(v, arrays), bool(arrays and v.array)
    text = " ".join(filter(None, map(_start, model.variables[row : row + size])))
    start, typed = [("start", text)] if text else [], _typed(model, v)
    rate = [("derivative", str(model.row(v.rate_of) + (version == 2)))] if v.rate_of else []
    if version == 2:
        scalar, kind = _head(v, row, v.name, v.meaning), "Integer" if v.integer else "Real"
        return {"type": kind, "scalar": scalar, "typed": [*typed, *start, *rate]}
    meaning = v.meaning.partition(", element")[0] if whole else v.meaning
    attributes = [*_head(v, row, v.array if whole else v.name, meaning), *typed, *rate, *start]
    kind, dimensions = "Int64" if v.integer else "Float64", [size] if whole else []
    return {"type": kind, "attributes": attributes, "dimensions": dimensions}


def _structure(model: FmuModel, version: int, arrays: bool) -> list[dict[str, Any]]:
    """Sections with at least one entry.

    In initialization mode variables are calculated from parameters and start values too; afterwards
    outputs depend on inputs and, in continuous models, on states.
    """
    rows = list(enumerate(model.variables))
    outputs, rates = ([i for i, v in rows if v.output], [i for i, v in rows if v.rate_of])
    results = [i for i, v in rows if v.role is Role.CALCULATED]
    listed = zip(SECTIONS[version], (outputs, rates, results), (False, False, True), strict=True)
    return [
        {"name": name, "unknowns": [_unknown(model, i, version, arrays, at_start) for i in chosen]}
        for name, chosen, at_start in listed
        if chosen
    ]


def _unknown(model: FmuModel, row: int, version: int, arrays: bool, at_start: bool) -> Attributes:
    """A variable and its dependencies; FMI 2 counts variables from 1, FMI 3 names references."""
    key, base = ("index", 1) if version == 2 else ("valueReference", 0)
    on: list[tuple[int, bool]] = []
    if model.variables[row].role is Role.START:  # a state that is an output: itself
        on = [(row, True)]
    elif model.dependencies is not None:
        every = model.dependencies[row]
        on = [(i, constant) for i, constant in every if at_start or model.variables[i].known]
    elif at_start:
        return [(key, str(row + base))]
    heads: dict[int, bool] = {}  # an array's head in place of its elements, constant if all are
    for i, constant in on:
        variable = model.variables[i]
        head = i - variable.index if arrays and variable.array else i
        heads[head] = heads.get(head, True) and constant
    kinds = {i: "constant" if constant else "dependent" for i, constant in sorted(heads.items())}
    return [
        (key, str(row + base)),
        ("dependencies", " ".join(str(i + base) for i in kinds)),
        ("dependenciesKind", " ".join(kinds.values())),
    ]
