"""Cases of two axes at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from wmr_ctrl.proofs.case import POSITIVE, Case
from wmr_ctrl.proofs.regions import AxisName, open_cases


def joined(one: Case, two: Case) -> Case:
    """Both cases together; their inputs and numbers must have different names."""

    def values(n: Mapping[str, Any]) -> dict[str, Any]:
        return {**one.values(n), **two.values(n)}

    return Case(
        f"{one.label}; {two.label}",
        {**one.numbers, **two.numbers},
        values,
        {**one.declared, **two.declared},
    )


def paired(one: Iterable[Case], two: Iterable[Case]) -> tuple[Case, ...]:
    """Case k of the first axis with case k of the second."""
    return tuple(joined(a, b) for a, b in zip(one, two, strict=True))


def paired_cases(one: AxisName, two: AxisName) -> tuple[Case, ...]:
    """Every open region of each axis once, against a different one of the other.

    Enough where the statement is a sum of one term per axis: terms of independent variables whose
    sum is 0 are constant on their regions.
    """
    return paired(open_cases(one), open_cases(two)[::-1])


def renamed(
    case: Case, names: Mapping[str, str], declared: Mapping[str, str] | None = None
) -> Case:
    """The case with its inputs under other names."""

    def values(n: Mapping[str, Any]) -> dict[str, Any]:
        return {names.get(key, key): value for key, value in case.values(n).items()}

    return Case(case.label, case.numbers, values, {**case.declared, **(declared or {})})


def law_cases(cases: Iterable[Case], axis: int) -> tuple[Case, ...]:
    """Cases of one axis under the names of a law's ports."""
    k = axis + 1
    names = {"v": ("v1", "omega")[axis], "u1": f"limits.v_u1[{k}]", "u2": f"limits.v_u2[{k}]"}
    masses = dict.fromkeys(("model.m", "model.I", "robot.v_s"), POSITIVE)
    return tuple(renamed(case, names, masses) for case in cases)
