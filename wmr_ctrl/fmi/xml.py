"""modelDescription.xml and its companions: what the templates print, decided here."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.fmi.files import render
from wmr_ctrl.fmi.model import FmuModel, Unknown, headed, initial_unknowns, outputs, rates
from wmr_ctrl.fmi.sources import Sources, row_size
from wmr_ctrl.fmi.units import NamedUnit, unit_of, units_of
from wmr_ctrl.fmi.variables import Role, Variable
from wmr_ctrl.laws import LAWS
from wmr_ctrl.signals import POSE, REFERENCE, TORQUE, TORQUE_NOISE, VELOCITY

Attributes = list[tuple[str, str]]
TERMINALS = (
    ("reference", "the desired trajectory", REFERENCE),
    ("pose", "position and orientation", POSE),
    ("velocity", "linear and angular velocity", VELOCITY),
    ("torque", "wheel torques", TORQUE),
    ("disturbance", "disturbance torques on the wheels", TORQUE_NOISE),
)
_CAUSALITY = {
    Role.INDEPENDENT: "independent",
    Role.INPUT: "input",
    Role.FIXED: "parameter",
    Role.TUNABLE: "parameter",
}


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
    common = _common(model, sources, tool, note)
    if version == 2:
        listed = [_fmi2_variable(model, i, v) for i, v in enumerate(model.variables)]
        return render(
            "fmi2.xml",
            m={
                **common,
                "variables": listed,
                "structure": _structure(model, FMI2, False),
            },
        )
    rows = [(i, v) for i, v in enumerate(model.variables) if row_size(v, arrays)]
    return render(
        "fmi3.xml",
        m={
            **common,
            "structure": _structure(model, FMI3, arrays),
            "variables": [_fmi3_variable(model, i, v, arrays) for i, v in rows],
        },
    )


def build_description(model: FmuModel, sources: Sources) -> str:
    """Text of sources/buildDescription.xml, FMI 3."""
    return render(
        "buildDescription.xml", m={"identifier": model.identifier, "units": sources.units}
    )


def terminals(model: FmuModel) -> str:
    """Text of terminalsAndIcons/terminalsAndIcons.xml, FMI 3."""
    ports = {v.name for v in model.variables if v.output or v.role is Role.INPUT}
    listed = [
        {"name": name, "text": text, "members": [s.name for s in signals]}
        for name, text, signals in TERMINALS
        if all(s.name in ports for s in signals)
    ]
    return render("terminalsAndIcons.xml", m={"terminals": listed})


def documentation(model: FmuModel, tool: str) -> str:
    """Text of documentation/index.html."""
    rows = [
        {
            "name": v.name,
            "unit": v.unit,
            "kind": _causality(v),
            "meaning": v.meaning,
            "start": "" if _start(v) is None else f"{v.start:.6g}",
        }
        for v in model.variables
    ]
    return render(
        "index.html",
        m={
            "identifier": model.identifier,
            "title": model.title,
            "tool": tool,
            "scenario": model.scenario.name,
            "kind": model.kind,
            "law": model.what in LAWS,
            "documented": rows,
        },
    )


def _common(model: FmuModel, sources: Sources, tool: str, note: str) -> dict[str, Any]:
    clock = model.scenario.clock
    return {
        "identifier": model.identifier,
        "token": sources.token,
        "title": model.title + note,
        "tool": tool,
        "version": tool.rpartition(" ")[2],
        "license": "BSD-3-Clause",
        "units": sources.units,
        "unit_definitions": [_unit(unit) for unit in _units(model.variables)],
        "duration": repr(clock.duration),
        "step": repr(model.step),
        "internal_step": repr(clock.plant if model.kind == "continuous" else clock.control),
        "derivatives": bool(model.graph),
        "model_exchange": model.model_exchange,
    }


def _units(variables: Iterable[Variable]) -> list[NamedUnit]:
    """The different units; ArgumentError, which names the variable, for what is none."""
    listed = list(variables)
    for item in listed:
        try:
            unit_of(item.unit)
        except ArgumentError as error:
            raise ArgumentError(f"{item.name}: {error}") from None
    return units_of(item.unit for item in listed)


def _unit(unit: NamedUnit) -> dict[str, Any]:
    base = [*unit.exponents.items(), *([] if unit.factor == 1 else [("factor", repr(unit.factor))])]
    display = [{"name": unit.display[0], "factor": repr(unit.display[1])}] if unit.display else []
    return {"name": unit.name, "base": base, "display": display}


def _causality(v: Variable) -> str:
    return _CAUSALITY.get(v.role, "output" if v.output else "local")


def _variability(v: Variable) -> str:
    if v.parameter:
        return "fixed" if v.role is Role.FIXED else "tunable"
    return "discrete" if v.discrete or v.integer else "continuous"


def _initial(v: Variable) -> Attributes:
    if v.role in (Role.INDEPENDENT, Role.INPUT):
        return []
    return [("initial", "calculated" if v.role is Role.CALCULATED else "exact")]


def _start(v: Variable) -> str | None:
    if v.role in (Role.INDEPENDENT, Role.CALCULATED):
        return None
    return str(int(v.start)) if v.integer else repr(v.start)


def _range(v: Variable) -> Attributes:
    ends = (("min", v.low), ("max", v.high))
    return [
        (key, str(int(end)) if v.integer else repr(end)) for key, end in ends if math.isfinite(end)
    ]


def _typed(model: FmuModel, v: Variable) -> Attributes:
    """Attributes that belong to the value: unit, display unit, range, nominal."""
    if v.integer:
        return _range(v)
    display = unit_of(v.unit).display
    nominal = [("nominal", "1.0")] if model.kind == "continuous" and v.role is Role.START else []
    shown = [("displayUnit", display[0])] if display else []
    return [("unit", v.unit), *shown, *_range(v), *nominal]


def _fmi2_variable(model: FmuModel, row: int, v: Variable) -> dict[str, Any]:
    scalar = [
        ("name", v.name),
        ("valueReference", str(row)),
        ("description", v.meaning),
        ("causality", _causality(v)),
        ("variability", _variability(v)),
        *_initial(v),
    ]
    start = _start(v)
    typed = [*_typed(model, v), *([] if start is None else [("start", start)])]
    if v.rate_of:
        typed.append(("derivative", str(model.row(v.rate_of) + 1)))
    return {"type": "Integer" if v.integer else "Real", "scalar": scalar, "typed": typed}


def _fmi3_variable(model: FmuModel, row: int, v: Variable, arrays: bool) -> dict[str, Any]:
    size = row_size(v, arrays)
    whole = bool(arrays and v.array)
    elements = model.variables[row : row + size]
    starts = [start for start in map(_start, elements) if start is not None]
    attributes = [
        ("name", v.array if whole else v.name),
        ("valueReference", str(row)),
        ("description", v.meaning.partition(", element")[0] if whole else v.meaning),
        ("causality", _causality(v)),
        ("variability", _variability(v)),
        *_initial(v),
        *_typed(model, v),
    ]
    if v.rate_of:
        attributes.append(("derivative", str(model.row(v.rate_of))))
    attributes += [("start", " ".join(starts))] if starts else []
    return {
        "type": "Int64" if v.integer else "Float64",
        "attributes": attributes,
        "dimensions": [size] if whole else [],
    }


FMI2 = (
    "index",
    1,
    (("Outputs", outputs), ("Derivatives", rates), ("InitialUnknowns", initial_unknowns)),
)
FMI3 = (
    "valueReference",
    0,
    (
        ("Output", outputs),
        ("ContinuousStateDerivative", rates),
        ("InitialUnknown", initial_unknowns),
    ),
)


def _structure(
    model: FmuModel, dialect: tuple[str, int, Any], arrays: bool
) -> list[dict[str, Any]]:
    """Sections with at least one entry; FMI 2 counts variables from 1, FMI 3 names references."""
    name, base, sections = dialect
    listed = ((title, list(find(model))) for title, find in sections)
    return [
        {
            "name": title,
            "unknowns": [_unknown(model, item, name, base, arrays) for item in unknowns],
        }
        for title, unknowns in listed
        if unknowns
    ]


def _unknown(model: FmuModel, unknown: Unknown, name: str, base: int, arrays: bool) -> Attributes:
    row, on = unknown
    if on is None:
        return [(name, str(row + base))]
    rows = headed(model, on, arrays)
    return [
        (name, str(row + base)),
        ("dependencies", _words(i + base for i, _ in rows)),
        (
            "dependenciesKind",
            _words("constant" if constant else "dependent" for _, constant in rows),
        ),
    ]


def _words(items: Iterable[object]) -> str:
    return " ".join(map(str, items))
