"""The table of many runs: labels, outcomes and figures, and the spread of a figure over runs."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.core.fields.arguments import checks_arguments

from .figures import FIGURES
from .frames import figure, table_frame, table_html
from .outcomes import Outcome

if TYPE_CHECKING:
    import pandas

Column: TypeAlias = NDArray[np.float64]
LABELS = frozenset(
    ("case", "law", "base", "guard", "plant", "seed", "outcome", "refusal", "tracked", "reference")
)
"""Columns that are no figures."""
REFUSED = "refused"
"""Outcome of a run whose bounds the guard cannot meet."""
BROKE = (Outcome.LIMIT_VIOLATED, Outcome.DIVERGED, Outcome.NON_FINITE)
"""Outcomes of runs that left a velocity limit; leaving the guard's bounds is not that."""
STATISTICS = ("median", "min", "max", "q25", "q75", "mean", "std")
"""The statistics of a :class:`Spread`, in the order of the tables' rows."""
HEADS = ("seed", "outcome", "tracked")
SHOWN = (*HEADS, "position_rms", "ise_total", "max_abs_v1", "max_abs_v2")
"""Columns that notebooks show."""


@dataclass(frozen=True)
class Spread:
    """Statistics of ``count`` numbers: median, extremes, quartiles, mean and standard deviation.

    ``std`` divides by ``count``.  All are None if there is no number.
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
        """Values of all :data:`STATISTICS` by name."""
        return {name: getattr(self, name) for name in STATISTICS}


def spread(values: Iterable[float | None]) -> Spread:
    """The spread of those values that are neither None nor NaN."""
    numbers = np.array(list(values), dtype=np.float64)
    numbers = numbers[~np.isnan(numbers)]
    if not numbers.size:
        return Spread(0)
    low, q25, median, q75, high = np.quantile(numbers, (0, 0.25, 0.5, 0.75, 1)).tolist()
    mean, std = float(np.mean(numbers)), float(np.std(numbers))
    return Spread(numbers.size, median, low, high, q25, q75, mean, std)


def median(values: Iterable[float | None]) -> float | None:
    """Median of the values that are neither None nor NaN; None if there is none."""
    there = [value for value in values if value is not None and value == value]
    return float(statistics.median(there)) if there else None


@dataclass(frozen=True, eq=False, repr=False)
class RunTable(Mapping[str, Column]):
    """Many runs: arrays by name, with one row per run, in the order in which they were requested.

    Columns are figures of the catalogue in their units (NaN: the run has none) and labels.
    ``seed`` and ``outcome`` (text) are always there.  `simulate_many` adds ``tracked`` (bool, RMS
    of drive and end against metrics.tolerance) and the events of `sim.figures.EVENTS`.  Planned
    runs have ``case``, ``law``, ``base``, ``guard`` (None: as the scenario says), ``plant`` and
    ``refusal``, the guard's message if it refused.  A run's remarks need its whole log:
    `wmr_ctrl.simulate_runs`.
    """

    columns: Mapping[str, Column] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<RunTable, {self.rows} runs, {len(self)} columns>"

    def _repr_html_(self) -> str:
        names = [name for name in SHOWN if name in self]
        units = {f.name: f.unit for f in FIGURES if f.name not in HEADS}
        heads = [f"{name} [{units[name]}]" if name in units else name for name in names]
        cells = [[figure(self[name][k].item()) for name in names] for k in range(min(self.rows, 8))]
        return table_html(f"{self.rows} runs", cells, heads)

    @property
    def rows(self) -> int:
        """Number of runs."""
        return len(next(iter(self.columns.values()), ()))

    @checks_arguments
    def to_dataframe(self) -> pandas.DataFrame:
        """One row per run, one number per column; units in ``attrs``.  Raises MissingExtraError."""
        return table_frame(self.columns, {figure.name: figure.unit for figure in FIGURES})

    @checks_arguments
    def __getitem__(self, name: str) -> Column:
        if name not in self.columns:
            raise UnknownNameError("column", name, self.columns)
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def records(self) -> list[dict[str, object]]:
        """One dictionary of plain values per run, with None for NaN."""
        lists = {name: [plain(x) for x in column.tolist()] for name, column in self.items()}
        return [dict(zip(lists, row, strict=True)) for row in zip(*lists.values(), strict=True)]

    def at(self, places: NDArray[np.intp] | NDArray[np.bool_]) -> RunTable:
        """The rows with these indices, or where a mask is true."""
        return RunTable({name: column[places] for name, column in self.items()})

    def where(self, **labels: object) -> RunTable:
        """The rows that have each of these labels; a label of None matches all rows."""
        mask = np.full(self.rows, True)
        for name, wanted in labels.items():
            if wanted is not None:
                mask &= np.asarray(self[name] == wanted)
        return self.at(mask)

    def different(self, label: str) -> tuple[str, ...]:
        """Distinct values of a label, in order."""
        return tuple(dict.fromkeys(self.columns[label].tolist() if self.columns else ()))

    @property
    def laws(self) -> tuple[str, ...]:
        """Names of the laws, in order."""
        return self.different("law")

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds in ascending order."""
        return tuple(sorted(set(self["seed"].tolist())))

    @property
    def cases(self) -> tuple[tuple[str, str], ...]:
        """Every pair of a case's name and law, in order."""
        return tuple(dict.fromkeys(zip(*(self[n].tolist() for n in ("case", "law")), strict=True)))

    def case(self, name: str, law: str) -> RunTable:
        """The rows of a case and law; raises UnknownNameError without any."""
        rows = self.where(case=name, law=law)
        if not rows.rows:
            known = (f"{one} with {other}" for one, other in self.cases)
            raise UnknownNameError("case", f"{name} with {law}", known)
        return rows

    def by_seed(self, figure: str) -> dict[int, float | None]:
        """A figure by seed; raises UnknownNameError."""
        pairs = zip(self["seed"].tolist(), map(plain, self[figure].tolist()), strict=True)
        return dict(pairs)

    def spread(self, figure: str) -> Spread:
        """The spread of a figure over the runs."""
        return spread(self[figure].tolist())

    def median(self, figure: str) -> float | None:
        """Median of a figure over the runs that have it; None if none has."""
        return median(self[figure].tolist())

    @property
    def broken(self) -> RunTable:
        """The runs that left a velocity limit."""
        return self.at(np.isin(self["outcome"], BROKE))


def ratios(
    values: Mapping[int, float | None], others: Mapping[int, float | None]
) -> dict[int, float | None]:
    """Ratio of the values of each seed; None if one is missing or the divisor is 0."""
    both = {seed: (value, others[seed]) for seed, value in values.items() if seed in others}
    return {seed: a / b if a is not None and b else None for seed, (a, b) in both.items()}


def plain(value: float) -> float | None:
    """None for NaN; other values unchanged."""
    return value if value == value else None


def table_of_rows(rows: Sequence[Mapping[str, object]]) -> RunTable:
    """The table of runs as mappings of labels and figures; a figure that a run lacks is NaN."""
    columns: dict[str, Column] = {}
    for name in dict.fromkeys(name for row in rows for name in row):
        values = [row.get(name) for row in rows]
        columns[name] = np.array(values) if name in LABELS else np.array(values, dtype=float)
    return RunTable(columns)
