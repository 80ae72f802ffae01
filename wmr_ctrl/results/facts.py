"""What two runs say of themselves, apart from their logs, and where they say different things."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from wmr_ctrl.results.run import Run

_ABSENT = "(absent)"


@dataclass(frozen=True, slots=True)
class Fact:
    """A property that two runs do not share: its name, and its value in either as text."""

    name: str
    in_a: str
    in_b: str


def differing_facts(run_a: Run, run_b: Run, tolerance: float) -> tuple[Fact, ...]:
    """The labels, settings, monitor's readings and provenance that differ.

    Numbers that differ by no more than ``tolerance``, times their size above 1, count as the same.
    """
    a, b = dict(_facts(run_a)), dict(_facts(run_b))
    names = list(dict.fromkeys((*a, *b)))
    return tuple(
        Fact(name, str(a.get(name, _ABSENT)), str(b.get(name, _ABSENT)))
        for name in names
        if not _same(a.get(name, _ABSENT), b.get(name, _ABSENT), tolerance)
    )


def _facts(run: Run) -> Iterator[tuple[str, Any]]:
    for name in ("scenario", "law", "guard", "seed", "engine"):
        yield name, getattr(run, name)
    yield "outcome", run.outcome.value
    groups = {"settings": asdict(run.settings), "monitor": asdict(run.monitor)}
    for group, values in {**groups, "provenance": run.provenance}.items():
        yield from ((f"{group}.{key}", value) for key, value in values.items())


def _same(a: Any, b: Any, tolerance: float) -> bool:
    if isinstance(a, tuple) and isinstance(b, tuple):
        return all(_same(x, y, tolerance) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) and isinstance(b, float):
        close = abs(a - b) <= tolerance * max(1.0, min(abs(a), abs(b)))
        return a == b or (math.isnan(a) and math.isnan(b)) or close
    return bool(a == b)
