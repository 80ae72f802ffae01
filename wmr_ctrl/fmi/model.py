"""FmuModel: what goes into one FMU, from a scenario: variables, C sources, ModelStructure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from wmr_ctrl.codegen.emit import Kernel
from wmr_ctrl.fmi.variables import Role, Variable, is_known
from wmr_ctrl.scenario import Scenario

KINDS = {"continuous": "WMR_CONTINUOUS", "sampled": "WMR_SAMPLED", "loop": "WMR_LOOP"}
RUNTIME = {
    "continuous": (),
    "sampled": (),
    "loop": ("loop.c", "loop.h", "noise.c", "noise.h", "seed.c", "seed.h"),
}
"""Files of fmu/runtime that a kind of model needs besides arithmetic.h."""


@dataclass(frozen=True)
class Dependency:
    """A calculated variable, by row, with the rows that it depends on; True: linearly, constant."""

    row: int
    on: tuple[tuple[int, bool], ...]


@dataclass(frozen=True)
class FmuModel:
    """One FMU's content before any file is written.

    ``constants`` and ``layout``: names and numbers for the kernels and for the FMI layer;
    ``tables``: named integer or float arrays for C;
    ``dependencies``: Jacobian structure of calculated variables, None where they depend on all;
    ``graph``: the serialised CasADi function.
    """

    what: str
    title: str
    kind: str
    scenario: Scenario
    variables: tuple[Variable, ...]
    constants: Mapping[str, int | str]
    kernels: tuple[Kernel, ...]
    derivatives: tuple[Kernel, ...]
    layout: Mapping[str, int]
    tables: Mapping[str, Sequence[Sequence[float]]]
    dependencies: tuple[Dependency, ...] | None
    model_exchange: bool
    step: float
    graph: str

    @property
    def identifier(self) -> str:
        """Model identifier: a C name."""
        return f"wmr_{self.what.replace('-', '_')}"

    @property
    def states(self) -> tuple[int, ...]:
        """Rows of the continuous states."""
        return tuple(
            i
            for i, v in enumerate(self.variables)
            if self.kind == "continuous" and v.role is Role.START
        )

    def row(self, name: str) -> int:
        """Row of the variable called ``name``."""
        return next(i for i, item in enumerate(self.variables) if item.name == name)


ORDERS = {("limits.v_u2", "limits.v_u1"): True, ("guard.M_min", "guard.M_max"): False}
"""Parameters of which the first must be below the second in each element, or (False) not above."""


def orders(model: FmuModel) -> list[tuple[int, int, bool]]:
    """Rows of parameters that initialisation keeps in order, and whether they must differ.

    Where the model's own numbers are not in order, nothing acts on them.
    """
    at = {row.name: i for i, row in enumerate(model.variables) if row.parameter}
    pairs = []
    for (low, high), apart in ORDERS.items():
        for first in (name for name in at if name.partition("[")[0] == low):
            second = at.get(first.replace(low, high, 1))
            if second is None:
                continue
            less, more = model.variables[at[first]].start, model.variables[second].start
            if less < more or (less == more and not apart):
                pairs.append((at[first], second, apart))
    return pairs


Unknown: TypeAlias = tuple[int, list[tuple[int, bool]] | None]
"""Row of a calculated variable, and the rows that it depends on (True: linearly, constant)."""


def outputs(model: FmuModel) -> list[Unknown]:
    """Every output; in sampled models they depend on inputs, in continuous ones on states too."""
    return [_entry(model, i, at_start=False) for i, v in enumerate(model.variables) if v.output]


def rates(model: FmuModel) -> list[Unknown]:
    """The rates of the continuous states."""
    return [_entry(model, i, at_start=False) for i, v in enumerate(model.variables) if v.rate_of]


def initial_unknowns(model: FmuModel) -> list[Unknown]:
    """What is calculated in initialization mode, from inputs, parameters and start values."""
    return [
        _entry(model, i, at_start=True)
        for i, v in enumerate(model.variables)
        if v.role is Role.CALCULATED
    ]


def headed(model: FmuModel, on: Iterable[tuple[int, bool]], arrays: bool) -> list[tuple[int, bool]]:
    """Dependencies with an array's head in place of its elements; constant if all of them are."""
    heads: dict[int, bool] = {}
    for row, constant in on:
        variable = model.variables[row]
        head = row - variable.index if arrays and variable.array else row
        heads[head] = heads.get(head, True) and constant
    return sorted(heads.items())


def _entry(model: FmuModel, row: int, *, at_start: bool) -> Unknown:
    if model.variables[row].role is Role.START:  # a state that is an output: itself
        return row, [(row, True)]
    if model.dependencies is None:
        return row, None if at_start else []
    on = next(item.on for item in model.dependencies if item.row == row)
    return row, [(i, constant) for i, constant in on if at_start or is_known(model.variables[i])]
