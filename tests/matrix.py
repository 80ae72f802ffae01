"""Which combinations of many cases are tried by default."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product

import pytest

from wmr_ctrl.laws.registry import NAMES


def crossed(*axes: Sequence[object]) -> list[object]:
    """Combinations for parametrize: those that differ from the first case in one way at most.

    The others are there too and are slow: `-m ''` runs them.
    """

    def usual(case: tuple[object, ...]) -> bool:
        return sum(value != axis[0] for value, axis in zip(case, axes, strict=True)) < 2

    return [
        pytest.param(*case, marks=() if usual(case) else pytest.mark.slow)
        for case in product(*axes)
    ]


def quick(names: Iterable[str], *shown: str) -> list[object]:
    """The names for parametrize; those that are not shown are slow."""
    return [pytest.param(n, marks=() if n in shown else pytest.mark.slow) for n in names]


def versioned(whats: Sequence[str], shown: str = "nn") -> list[object]:
    """FMUs by what they hold and version of FMI; of most laws the older version is slow."""
    rest = [name for name in NAMES if name != shown]
    return [
        pytest.param(what, version, marks=pytest.mark.slow if slow else ())
        for what, version in product(whats, (2, 3))
        for slow in [what in rest and version == 2]
    ]
