"""The report's tables as plain rows of text; their captions are in the templates."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from wmr_ctrl.core.data import data
from wmr_ctrl.results import FIGURES, Settings
from wmr_ctrl.results.table import RunTable, Spread
from wmr_ctrl.results.windows import robots_over, seconds, windows_of
from wmr_ctrl.simulation.campaign import Campaign

from .paper_claims import STAND_IN_LAW
from .style import ABSENT, look, shown, unit_text

T = TypeVar("T")
_KILO = {"m": "mm", "rad": "mrad"}
"""Units in which errors are short to read; the files keep metres and radians."""


@dataclass(frozen=True)
class TextTable:
    """A table for readers: headings, and rows whose first cell is their name."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def table_by_law(
    rows: Mapping[str, T],
    laws: Sequence[str],
    cell: Callable[[T, str], str],
    corner: str = "case",
) -> TextTable:
    """One row per item of ``rows``, one column per law."""
    return TextTable(
        (corner, *map(headed, laws)),
        tuple((name, *(cell(row, law) for law in laws)) for name, row in rows.items()),
    )


def headed(law: str) -> str:
    """A law's name above a column."""
    return f"{look(law).label} (stand-in)" if law == STAND_IN_LAW else look(law).label


def ranged(values: Spread, factor: float = 1.0, digits: int = 3) -> str:
    """Median, minimum and maximum as a cell."""
    if values.median is None or values.min is None or values.max is None:
        return ABSENT
    numbers = (factor * number for number in (values.median, values.min, values.max))
    middle, low, high = (shown(number, digits) for number in numbers)
    return middle if low == high else f"{middle} ({low} … {high})"


@dataclass(frozen=True)
class _Line:
    """A row of a scenario's table: figure and label.

    ``change``: only for scenarios with a change of the robot; ``short``: also in the short table.
    """

    figure: str
    label: str
    change: bool = False
    short: bool = False

    @property
    def factor(self) -> float:
        """Scale factor of the shown figure."""
        return 1e3 if FIGURES[self.figure].unit in _KILO else 1.0

    def name(self, settings: Settings) -> str:
        """The label with a run's windows inserted, and its unit."""
        windows, period = windows_of(settings), settings.control
        times = {name: (period * a, period * b) for name, (a, b) in windows.items()}
        robots = {name: robots_over(settings, *ends) for name, ends in times.items()}
        spans = {
            name: f"{seconds(*ends)}{': ' * bool(robots[name])}{robots[name]}"
            for name, ends in times.items()
        }
        label = self.label.format(**spans, split=windows["before"][1])
        unit = FIGURES[self.figure].unit
        shown_unit = _KILO.get(unit, unit_text(unit))
        return f"{label} [{shown_unit}]" if shown_unit else label


_LINES = tuple(_Line(**row) for row in data(__package__, "lines.toml")["line"])


def scenario_table(campaign: Campaign, scenario: str, short: bool = False) -> TextTable:
    """Median and range of the chief figures of a scenario, one column per law.

    Figures before and after a change are left out if the robot's parameters do not change.
    ``short``: the few figures that distinguish the laws.
    """
    table, run = campaign.table, campaign.runs[scenario, campaign.table.laws[0]]
    changes = bool(run.settings.robots)
    runs = {law: table.case(scenario, law) for law in table.laws}

    def cell(line: _Line, law: str) -> str:
        if line.figure == "violated":
            return _broken(runs[law])
        return ranged(runs[law].spread(line.figure), line.factor)

    lines = [line for line in _LINES if (changes or not line.change) and (line.short or not short)]
    named = {line.name(run.settings): line for line in lines}
    return table_by_law(named, table.laws, cell, "")


def _broken(runs: RunTable) -> str:
    return f"{int((runs['violated'] > 0).sum())} of {runs.rows}"


def stress_table(
    table: RunTable, scenarios: Mapping[str, str], laws: Sequence[str] = ()
) -> TextTable:
    """Share of seeds beyond the limit and the largest |v|/limit; ``scenarios`` by title."""

    def cell(scenario: str, law: str) -> str:
        runs = table.case(scenario, law)
        return f"{_broken(runs)}: {ranged(runs.spread('limit_ratio'), digits=4)}"

    return table_by_law(scenarios, laws or table.laws, cell)
