"""modelDescription.xml and its companions: the values that the templates print."""

import math
from collections.abc import Iterable

from wmr_ctrl.codegen.package import FILTER
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.named_units import NamedUnit, unit_of, units_of

from .files import Sources, render, row_size
from .model_description import FmuModel, Role, Variable

Attributes = list[tuple[str, str]]
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
    """Text of modelDescription.xml for FMI 2 or 3; ``note``: text after the title."""
    arrays, rows = arrays and version == 3, enumerate(model.variables)
    return render(
        f"fmi{version}.xml", model=model, units=sources.units, token=sources.token,
        title=model.title + note, tool=tool, unit_definitions=_units(model.variables),
        clock=model.scenario.clock, unit_of=unit_of, inf=math.inf,
        rows=[(i, v, row_size(v, arrays), arrays and v.array) for i, v in rows],
        structure=_structure(model, version, arrays),
    )  # fmt: skip


def documentation(model: FmuModel, tool: str) -> str:
    """Text of documentation/index.html."""
    return render("index.html", model=model, tool=tool, packed=model.what in (*LAWS, FILTER))


def _units(variables: Iterable[Variable]) -> list[NamedUnit]:
    """The distinct units; ArgumentError, which names the variable, for an unknown one."""
    listed = list(variables)
    for item in listed:
        try:
            unit_of(item.unit)
        except ArgumentError as error:
            raise ArgumentError(f"{item.name}: {error}") from None
    return units_of(item.unit for item in listed)


def _structure(model: FmuModel, version: int, arrays: bool) -> list[tuple[str, list[Attributes]]]:
    """Sections with at least one entry.

    In initialization mode variables depend on parameters and start values, too; afterwards outputs
    depend on inputs and, in continuous models, on states.
    """
    rows = list(enumerate(model.variables))
    outputs, rates = ([i for i, v in rows if v.output], [i for i, v in rows if v.rate_of])
    results = [i for i, v in rows if v.role is Role.CALCULATED]
    listed = zip(SECTIONS[version], (outputs, rates, results), (False, False, True), strict=True)
    return [
        (name, [_unknown(model, i, version, arrays, at_start) for i in chosen])
        for name, chosen, at_start in listed
        if chosen
    ]


def _unknown(model: FmuModel, row: int, version: int, arrays: bool, at_start: bool) -> Attributes:
    """A variable and its dependencies; FMI 2 counts variables from 1, FMI 3 uses references."""
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
