"""The rows of a campaign: a run as plain numbers, their table, and the spread over seeds."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.campaign.plan import PlannedCase
from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.results import Outcome
from wmr_ctrl.results.figures import FIGURES, Figure
from wmr_ctrl.results.windows import WINDOWS, named

REFUSED = "refused"
"""Outcome of a run whose bounds the guard cannot meet."""
STATISTICS = ("median", "min", "max", "q25", "q75", "mean", "std")
"""The statistics of a :class:`Spread`, in the order of the table's rows."""


_WINDOWS = tuple(map(named, WINDOWS))
_REPORTED = (
    "position_rms", "position_rms_last_quarter", "position_max", "d_start",
    *(f"d_rms_{span}" for span in _WINDOWS), "halving_time", "settling_time",
    "ise_total", "ise_before", "ise_after", "ise_position", "ise_orientation",
    *(f"e{axis}_rms_{span}" for axis in (1, 2, 3) for span in _WINDOWS),
    "max_abs_v1", "max_abs_omega", "limit_ratio", "violated", "violations", "first_violation",
    "tau_peak", "tau_peak_late", "tau_rms", "V1_start", "V1_late", "V1_rises", "V1_rise_share",
    "W1_end", "W1_largest", "W2_end", "W2_largest",
)  # fmt: skip


def reported() -> tuple[Figure, ...]:
    """Figures of the report's tables, in their order; those of other packages at the end."""
    return (*map(FIGURES.__getitem__, _REPORTED), *FIGURES.plugins)


@dataclass(frozen=True, slots=True)
class Spread:
    """``count`` numbers in short: median, extremes, quartiles, mean and standard deviation.

    ``std`` divides by ``count``.  All are None where there is no number.
    """

    count: int
    median: float | None = None
    min: float | None = None
    max: float | None = None
    q25: float | None = None
    q75: float | None = None
    mean: float | None = None
    std: float | None = None

    @property
    def statistics(self) -> dict[str, float | None]:
        """Each of :data:`STATISTICS` by its name."""
        values = (self.median, self.min, self.max, self.q25, self.q75, self.mean, self.std)
        return dict(zip(STATISTICS, values, strict=True))


def spread(values: Iterable[float | None]) -> Spread:
    """The spread of those values that are not None."""
    numbers = np.array([value for value in values if value is not None], dtype=np.float64)
    if not numbers.size:
        return Spread(0)
    low, q25, median, q75, high = np.quantile(numbers, (0, 0.25, 0.5, 0.75, 1)).tolist()
    mean, std = float(np.mean(numbers)), float(np.std(numbers))
    return Spread(numbers.size, median, low, high, q25, q75, mean, std)


def median(values: Iterable[float | None]) -> float | None:
    """Median of the values that are there; None if none is."""
    there = [value for value in values if value is not None]
    return float(statistics.median(there)) if there else None


@dataclass(frozen=True, slots=True)
class RunRow:
    """A run without its log: outcome ("refused" where the guard's bounds cannot be met), figures.

    ``values`` maps a figure's name to its number, None where the run has none; ``refusal``: the
    guard's words where it refused.
    """

    case: PlannedCase
    seed: int
    outcome: str
    values: Mapping[str, float | None]
    refusal: str = ""

    def __getitem__(self, figure: str) -> float | None:
        """A figure; None where the run has none."""
        return self.values.get(figure)

    @property
    def broke(self) -> bool:
        """True if the run left a velocity limit; leaving the guard's bounds is not that."""
        return self.outcome in (Outcome.LIMIT_VIOLATED, Outcome.DIVERGED, Outcome.NON_FINITE)


class FigureTable:
    """Rows in the order in which they were planned, and how to look numbers up in them."""

    def __init__(self, rows: Iterable[RunRow] = ()) -> None:
        self.rows = tuple(rows)
        self._cases: dict[tuple[str, str], list[RunRow]] = {}
        for row in self.rows:
            self._cases.setdefault((row.case.name, row.case.law), []).append(row)

    @property
    def cases(self) -> tuple[tuple[str, str], ...]:
        """Every pair of a case's name and law, in order."""
        return tuple(self._cases)

    @property
    def laws(self) -> tuple[str, ...]:
        """Names of the laws, in order."""
        return tuple(dict.fromkeys(row.case.law for row in self.rows))

    @property
    def bases(self) -> tuple[str, ...]:
        """Groups of cases, in order."""
        return tuple(dict.fromkeys(row.case.base for row in self.rows))

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds, from the least to the greatest."""
        return tuple(sorted({row.seed for row in self.rows}))

    def scenarios(self, base: str | None = None) -> tuple[str, ...]:
        """Names of the cases of a group (None: of any), in order."""
        cases = (row.case for row in self.rows)
        return tuple(dict.fromkeys(case.name for case in cases if base in (None, case.base)))

    def of(
        self,
        name: str,
        law: str,
        *,
        base: str | None = None,
        guard: bool | None = None,
        plant: str | None = None,
    ) -> tuple[RunRow, ...]:
        """The rows of a case and law, one per seed; None: whatever they have."""
        return tuple(
            row
            for row in self._cases.get((name, law), ())
            if base in (None, row.case.base)
            and guard in (None, row.case.guard)
            and plant in (None, row.case.plant)
        )

    def median(self, figure: str, base: str, name: str, law: str, guard: bool) -> float | None:
        """Median of a figure over the runs that have it; None if none has."""
        return median(row[figure] for row in self.of(name, law, base=base, guard=guard))

    def guarded(self, guard: bool = True) -> Iterator[RunRow]:
        """Runs with the guard, or without it, that were not refused."""
        return (r for r in self.rows if r.case.guard is guard and r.outcome != REFUSED)

    def case(self, scenario: str, law: str) -> tuple[RunRow, ...]:
        """The rows of a scenario and law; raises UnknownNameError without any."""
        if (scenario, law) not in self._cases:
            known = (f"{one} with {other}" for one, other in self._cases)
            raise UnknownNameError("case", f"{scenario} with {law}", known)
        return tuple(self._cases[scenario, law])

    def values(self, figure: str, scenario: str, law: str) -> dict[int, float | None]:
        """A figure by seed; raises UnknownNameError for names that are not there."""
        name = FIGURES[figure].name
        return {row.seed: row[name] for row in self.case(scenario, law)}

    def spread(self, figure: str, scenario: str, law: str) -> Spread:
        """The spread of a figure over the seeds."""
        return spread(self.values(figure, scenario, law).values())

    def __iter__(self) -> Iterator[RunRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)
