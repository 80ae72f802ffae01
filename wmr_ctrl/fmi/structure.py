"""ModelStructure: outputs, rates and initial unknowns, with what each depends on."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from wmr_ctrl.fmi.blocks import is_known
from wmr_ctrl.fmi.model import FmuModel
from wmr_ctrl.fmi.variables import Role

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
