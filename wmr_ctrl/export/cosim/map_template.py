"""A map file to fill in, made from the model descriptions of foreign FMUs.

Rows with equal names are filled in.  Every other row is a comment that lists the candidates.
"""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.files import note_output
from wmr_ctrl.core.fields.named_units import NamedUnit, unit_of

from .fmu_file import FLOATS, NO_NUMBERS, FmuFile
from .mapping import CHANGED, EITHER, GIVEN, TAKEN, UNITS, toml_key

_MOST = 12
"""Candidates that a comment names."""


def write_map_template(
    path: str | Path, plant: str | Path | None, controller: str | Path | None
) -> Path:
    """Write the template for one or both FMUs; raises ArgumentError if the file exists."""
    target = Path(path)
    files = {"plant": plant, "controller": controller}
    given = {name: FmuFile(file, name) for name, file in files.items() if file is not None}
    if not given:
        raise ArgumentError(
            "a map template needs the FMU whose names it lists: give --plant FILE.fmu, "
            "--controller FILE.fmu, or both."
        )
    if target.exists():
        raise ArgumentError(f"{target} exists, and is not overwritten. Name another file.")
    note_output(target)
    text = "\n".join(line for name, fmu in given.items() for line in _part(name, fmu))
    target.write_text(f"{text}\n", encoding="utf-8")
    return target


def _part(part: str, fmu: FmuFile) -> Iterator[str]:
    theirs = dict(fmu.numbers)
    inputs = {name: v for name, v in theirs.items() if v.causality == "input"}
    outputs = {name: v for name, v in theirs.items() if v.causality == "output"}
    yield f"# Map of {Path(fmu.path).name} ({fmu.description.modelName})."
    yield "# Remove the first # of a row that fits."
    yield f"[{part}]"
    default = fmu.description.defaultExperiment
    step = default.stepSize if default else None
    yield f"{'' if step else '# '}step = {step or 0.005}  # s, communication step of the FMU"
    if not all(fmu.unit(name) for name in (*inputs, *outputs)):
        yield '# units = "SI"  # if all variables for which the FMU gives no unit are in SI units'
    yield f"[{part}.inputs]  # theirs = ours"
    ours = {name: UNITS[name] for name in TAKEN[part]}
    for name, variable in inputs.items():
        if variable.type == "Boolean":
            yield f"# {toml_key(name)} = true  # Boolean"
        else:
            yield _row(name, fmu.unit(name), ours, fmu.unit(name))
    yield f"[{part}.outputs]  # ours = theirs"
    known = {name: fmu.unit(name) for name in outputs}
    filled: set[str] = set()
    for name in GIVEN[part]:
        row = _row(name, UNITS[name], known, all(known.values()))
        if any(name in other and filled.intersection(one) for one, other in EITHER[part]):
            row = f"# {row.removeprefix('# ')}"
        elif not row.startswith("#"):
            filled.add(name)
        yield row
    if part == "plant":
        parameters = {
            name: fmu.unit(name) for name, v in theirs.items() if v.variability == "tunable"
        }
        yield "[plant.parameters]  # ours = theirs, for scenarios that change them"
        for name in CHANGED:
            yield _row(name, CHANGED[name], parameters, all(parameters.values()))
    yield f"[{part}.start]  # start values of the FMU, where other ones are wanted"
    for name, variable in fmu.variables.items():
        if variable.initial == "exact" and variable.causality in ("output", "parameter"):
            unit = _unit_text(fmu.unit(name)) if variable.type in FLOATS else variable.type
            yield f"# {toml_key(name)} = {_start(variable)}  # {unit}"


def _row(
    target: str, unit: NamedUnit | str | None, sources: Mapping[str, Any], stated: object
) -> str:
    """The row of ``target``, filled in if one source has its name and a fitting unit.

    If the FMU's unit is not ``stated``, the row has a placeholder for it.
    """
    fitting = [name for name, other in sources.items() if _fits(unit, other)]
    alike = [name for name in fitting if _plain(name) == _plain(target)]
    others = ", ".join(fitting[:_MOST]) + (", ..." if len(fitting) > _MOST else "")
    left = f"{toml_key(target)} ="
    if len(alike) == 1 and stated:
        return f"{left} {json.dumps(alike[0])}  # {_unit_text(unit)}"
    source = toml_key(alike[0]) if len(alike) == 1 else '""'
    right = '""' if stated else f'{{ terms = {{ {source} = 1.0 }}, unit = "" }}'
    could = f"could be {others}" if others else "no variable has such a unit"
    return f"# {left} {right}  # {_unit_text(unit)}; {could}"


def _fits(one: NamedUnit | str | None, other: NamedUnit | str | None) -> bool:
    """True if both units measure the same kind of quantity, or one is unknown."""
    units = []
    for unit in (one, other):
        try:
            units.append(unit if isinstance(unit, NamedUnit) else unit_of(unit or ""))
        except ArgumentError:
            return True
    return units[0].fits(units[1])


def _plain(name: str) -> str:
    """A name in lower case, without signs and without its components' names."""
    return re.sub(r"[^a-z0-9]", "", re.split(r"\.(?=[^.]+$)", name)[-1].lower())


def _unit_text(unit: NamedUnit | str | None) -> str:
    name = unit.name if isinstance(unit, NamedUnit) else unit
    return f"[{name}]" if name else "the FMU gives no unit"


def _start(variable: Any) -> str:
    """A variable's start value as TOML, from its description; a list for an array."""
    if variable.type not in FLOATS:
        words = variable.start or "0"
        return words if variable.type not in NO_NUMBERS else json.dumps(variable.start or "")
    numbers = [float(word) for word in (variable.start or "0").split()]
    return str(numbers if variable.shape else numbers[0])
