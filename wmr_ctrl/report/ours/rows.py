"""The comparison's rows, asked by base, case, law and guard."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from wmr_ctrl.campaign.ours_run import REFUSED, Comparison
from wmr_ctrl.results import Outcome

BASE = "base"
OUTSIDE = "start outside"


@dataclass(frozen=True)
class Rows:
    """All rows, in the plan's order."""

    all: tuple[Comparison, ...]

    @property
    def bases(self) -> tuple[str, ...]:
        """Base cases, in order."""
        return tuple(dict.fromkeys(row.case.base for row in self.all))

    @property
    def laws(self) -> tuple[str, ...]:
        """Laws, in order."""
        return tuple(dict.fromkeys(row.case.law for row in self.all))

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds, from the least to the greatest."""
        return tuple(sorted({row.case.seed for row in self.all}))

    def factors(self, base: str | None = None) -> tuple[str, ...]:
        """Cases of a base (None: of any), in order."""
        return tuple(dict.fromkeys(r.case.factor for r in self.all if base in (None, r.case.base)))

    def of(self, base: str, factor: str, law: str, guard: bool) -> tuple[Comparison, ...]:
        """The runs of one case, one per seed."""
        wanted = (base, factor, law, guard)
        return tuple(r for r in self.all if _key(r) == wanted)

    def median(self, name: str, base: str, factor: str, law: str, guard: bool) -> float | None:
        """Median of a figure over the runs that have it; None if none has."""
        return median(getattr(row, name) for row in self.of(base, factor, law, guard))

    def guarded(self, guard: bool = True) -> Iterator[Comparison]:
        """Runs with the guard, or without it, that were not refused."""
        return (r for r in self.all if r.case.guard is guard and r.outcome != REFUSED)


def median(values: Iterable[float | None]) -> float | None:
    """Median of the values that are there; None if none is."""
    there = [value for value in values if value is not None]
    return float(statistics.median(there)) if there else None


def broke(row: Comparison) -> bool:
    """Whether the run left a velocity limit; leaving the guard's bounds is not that."""
    return row.outcome in (Outcome.LIMIT_VIOLATED, Outcome.DIVERGED, Outcome.NON_FINITE)


def _key(row: Comparison) -> tuple[str, str, str, bool]:
    return row.case.base, row.case.factor, row.case.law, row.case.guard
