"""Which combinations of many cases are tried by default."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import product
from typing import TypeAlias

import pytest

from wmr_ctrl.control.laws.registry import NAMES


def headed(first: str, names: Iterable[str]) -> tuple[str, ...]:
    """The names with this one first."""
    return (first, *(name for name in names if name != first))


def rotated(*axes: Sequence[object]) -> list[object]:
    """Combinations for parametrize: those that differ from the first case in one way at most.

    Slow is, of each value, one more in changing company: products grow too fast, and faults that
    need three values at a time to show are rare.
    """
    usual = [
        case
        for case in product(*(range(len(axis)) for axis in axes))
        if sum(place > 0 for place in case) < 2
    ]
    rounds = range(1, max(map(len, axes)))
    slow = [tuple(1 + (k - 1) % (len(axis) - 1) for axis in axes) for k in rounds]
    return _marked(axes, usual, slow)


def turns(*axes: Sequence[object], shown: int = 2) -> list[object]:
    """As many combinations as the longest axis has values; the others' values take turns.

    The first ``shown`` of them are run by default, the others are slow.
    """
    longest = max(range(len(axes)), key=lambda j: len(axes[j]))
    sizes = [1 if j == longest else len(axis) for j, axis in enumerate(axes)]
    strides = [math.prod(sizes[:j]) for j in range(len(axes))]
    cases = [
        tuple(k if j == longest else k // strides[j] % len(axis) for j, axis in enumerate(axes))
        for k in range(len(axes[longest]))
    ]
    return _marked(axes, cases[:shown], cases[shown:])


SHOWN_LAWS = (("nn", 2), ("nn", 3), ("prox", 3))
"""Controllers of which FMUs are built by default, with the version of FMI."""
Case: TypeAlias = tuple[int, ...]
"""Which value of each axis."""


def _marked(
    axes: Sequence[Sequence[object]], usual: Iterable[Case], slow: Iterable[Case]
) -> list[object]:
    def values(case: Case) -> list[object]:
        return [axis[place] for axis, place in zip(axes, case, strict=True)]

    return [pytest.param(*values(case)) for case in usual] + [
        pytest.param(*values(case), marks=pytest.mark.slow) for case in slow
    ]


def quick(names: Iterable[str], *shown: str) -> list[object]:
    """The names for parametrize; those that are not shown are slow."""
    return [pytest.param(n, marks=() if n in shown else pytest.mark.slow) for n in names]


def versioned(whats: Sequence[str], shown: Sequence[tuple[str, int]] = SHOWN_LAWS) -> list[object]:
    """FMUs by what they hold and version of FMI; of laws all but those shown are slow."""
    return [
        pytest.param(
            *case, marks=pytest.mark.slow if case[0] in NAMES and case not in shown else ()
        )
        for case in product(whats, (2, 3))
    ]
