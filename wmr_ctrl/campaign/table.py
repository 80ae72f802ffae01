"""The rows of a campaign: a run as plain numbers, their table, and the spread over seeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.results import Run
from wmr_ctrl.results.figures import FIGURES, Figure, values_of
from wmr_ctrl.results.windows import WINDOWS, named

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


@dataclass(frozen=True, slots=True)
class FigureRow:
    """A run without its log: ``values`` maps each figure's name to its number, None if none."""

    scenario: str
    law: str
    seed: int
    outcome: str
    values: Mapping[str, float | None]


def row_of(run: Run) -> FigureRow:
    """The run's labels, outcome and figures."""
    return FigureRow(run.scenario, run.law, run.seed, run.outcome.value, values_of(run, reported()))


class FigureTable:
    """Rows in the order in which they were planned, and how to look numbers up in them."""

    def __init__(self, rows: Iterable[FigureRow]) -> None:
        self.rows = tuple(rows)
        self._cases: dict[tuple[str, str], tuple[FigureRow, ...]] = {}
        for row in self.rows:
            key = (row.scenario, row.law)
            self._cases[key] = (*self._cases.get(key, ()), row)

    @property
    def cases(self) -> tuple[tuple[str, str], ...]:
        """Every pair of scenario and law, in order."""
        return tuple(self._cases)

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Names of the scenarios, in order."""
        return tuple(dict.fromkeys(scenario for scenario, _ in self._cases))

    @property
    def laws(self) -> tuple[str, ...]:
        """Names of the laws, in order."""
        return tuple(dict.fromkeys(law for _, law in self._cases))

    def case(self, scenario: str, law: str) -> tuple[FigureRow, ...]:
        """The rows of a scenario and law, one per seed; raises UnknownNameError without any."""
        try:
            return self._cases[scenario, law]
        except KeyError:
            known = (f"{one} with {other}" for one, other in self._cases)
            raise UnknownNameError("case", f"{scenario} with {law}", known) from None

    def values(self, figure: str, scenario: str, law: str) -> dict[int, float | None]:
        """A figure by seed; raises UnknownNameError for names that are not there."""
        name = FIGURES[figure].name
        return {row.seed: row.values[name] for row in self.case(scenario, law)}

    def spread(self, figure: str, scenario: str, law: str) -> Spread:
        """The spread of a figure over the seeds."""
        return spread(self.values(figure, scenario, law).values())

    def __iter__(self) -> Iterator[FigureRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)
