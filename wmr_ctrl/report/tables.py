"""The report's tables as plain rows of text."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from wmr_ctrl.campaign import FigureTable, Spread
from wmr_ctrl.campaign.comparison import AWAY, E1, E1_BEFORE, FARTHEST, overrides_of
from wmr_ctrl.campaign.table import REFUSED, RunRow, median
from wmr_ctrl.report.claims import PAPER_TIMES, STAND_IN_LAW
from wmr_ctrl.report.style import ABSENT, look, shown, unit_text
from wmr_ctrl.results import Outcome
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.results.windows import BEFORE, LATE, WINDOWS, named


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table for readers: what it shows, its headings, and rows whose first cell names them.

    ``best``: for each row the places of its best cells; empty for a row or a table without any.
    """

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    best: tuple[frozenset[int], ...] = ()

    def is_best(self, row: int, place: int) -> bool:
        """Whether a cell is marked; both count from 0, the row's name included."""
        return bool(self.best) and place in self.best[row]


def least(values: Sequence[float | None]) -> frozenset[int]:
    """Places of the least value, counted from 1; none where all are as good, or none is there."""
    there = [value for value in values if value is not None]
    if not there or (len(there) == len(values) and min(there) == max(there)):
        return frozenset()
    return frozenset(k + 1 for k, value in enumerate(values) if value == min(there))


_KILO = {"m": "mm", "rad": "mrad"}
"""Units in which errors are short to read; the files keep metres and radians."""


@dataclass(frozen=True, slots=True)
class _Line:
    """A row of a scenario's table: a figure, what it is called, and whether less of it is better.

    ``change``: only where the robot's parameters change; ``short``: also in the short table.
    """

    figure: str
    label: str
    better: bool = True
    change: bool = False
    short: bool = False


def _windows(figure: str, text: str) -> tuple[_Line, ...]:
    return tuple(
        _Line(
            f"{figure}_rms_{named(span)}",
            f"RMS {text}, {span[0]}–{span[1]} s",
            change=span != LATE,
            short=span == LATE and figure == "e1",
        )
        for span in WINDOWS
    )


_BROKEN = "seeds that broke a limit"
_LINES = (
    _Line("position_rms_last_quarter", "RMS distance, 60–80 s", short=True),
    _Line("position_max", "largest distance, 60–80 s", short=True),
    _Line("position_rms", "RMS distance, 0–80 s"),
    *_windows("d", "distance"),
    *_windows("e1", "e₁"),
    *_windows("e2", "e₂"),
    *_windows("e3", "e₃"),
    _Line("ise_total", "ISE, 0–80 s", short=True),
    _Line("ise_before", "ISE, 0–40 s", change=True),
    _Line("ise_after", "ISE, 40–80 s", change=True),
    _Line("ise_position", "ISE without θ"),
    _Line("max_abs_v1", "largest |v₁|", better=False),
    _Line("max_abs_omega", "largest |ω|", better=False),
    _Line("violated", _BROKEN, short=True),
    _Line("tau_peak", "peak wheel torque", short=True),
    _Line("tau_rms", "RMS wheel torque, 2–80 s"),
    _Line("V1_rises", "rises of V₁ in the first 4000 samples", better=False),
    _Line("W1_end", "‖W₁‖ at the end", better=False),
    _Line("W2_end", "‖W₂‖ at the end", better=False),
)


def scenario_table(
    table: FigureTable, scenario: str, caption: str, *, changes: bool, short: bool = False
) -> TextTable:
    """Median and range of the chief figures of a scenario, a column per law.

    ``changes``: whether the robot's parameters change in it; without, nothing is told of a before
    and an after.  ``short``: the few figures that tell the laws apart.
    """
    lines = [line for line in _LINES if (changes or not line.change) and (line.short or not short)]
    rows = tuple(
        (
            _named(line.figure, line.label),
            *(_line_cell(table, line, scenario, law) for law in table.laws),
        )
        for line in lines
    )
    best = tuple(_best(table, line, scenario) for line in lines)
    return TextTable(caption, ("", *map(headed, table.laws)), rows, best)


def headed(law: str) -> str:
    """A law's name above a column."""
    return f"{look(law).label} (stand-in)" if law == STAND_IN_LAW else look(law).label


def _line_cell(table: FigureTable, line: _Line, scenario: str, law: str) -> str:
    if line.label == _BROKEN:
        return _share(table, scenario, law)
    return _figure(table, line.figure, scenario, law)


def _best(table: FigureTable, line: _Line, scenario: str) -> frozenset[int]:
    """The least median, or the least number of broken seeds."""
    if not line.better:
        return frozenset()
    spreads = [table.spread(line.figure, scenario, law) for law in table.laws]
    return least([one.mean if line.label == _BROKEN else one.median for one in spreads])


def stress_table(
    table: FigureTable, scenarios: Mapping[str, str], laws: Sequence[str] | None = None
) -> TextTable:
    """Share of seeds beyond the limit and the largest |v|/limit, per case and law."""
    shown_laws = tuple(laws or table.laws)
    rows = tuple(
        (title, *(_limit_cell(table, scenario, law) for law in shown_laws))
        for scenario, title in scenarios.items()
    )
    caption = "Seeds that broke a limit, and the largest |v|/limit: median (least … greatest)"
    return TextTable(caption, ("case", *map(headed, shown_laws)), rows)


def times_table(times: Mapping[str, float], laws: Sequence[str]) -> TextTable:
    """Milliseconds per 10,000 evaluations: the paper's and ours [s], side by side."""
    rows = tuple(
        (headed(law), _milliseconds(PAPER_TIMES.get(law)), _milliseconds(times.get(law)))
        for law in laws
    )
    return TextTable(
        "Milliseconds for 10,000 evaluations of the law",
        ("law", "paper (MATLAB, i5-3210M)", "here (compiled C, each call from Python)"),
        rows,
    )


def _named(name: str, label: str) -> str:
    if label == _BROKEN:
        return label
    unit = FIGURES[name].unit
    shown_unit = _KILO.get(unit, unit_text(unit))
    return f"{label} [{shown_unit}]" if shown_unit else label


def _figure(table: FigureTable, name: str, scenario: str, law: str) -> str:
    factor = 1000 if FIGURES[name].unit in _KILO else 1
    return _cell(table.spread(name, scenario, law), factor)


def _cell(given: Spread, factor: float = 1, digits: int = 3) -> str:
    if given.median is None or given.min is None or given.max is None:
        return ABSENT
    middle, low, high = (shown(factor * x, digits) for x in (given.median, given.min, given.max))
    return middle if low == high else f"{middle} ({low} … {high})"


def _share(table: FigureTable, scenario: str, law: str) -> str:
    values = table.values("violated", scenario, law).values()
    return f"{sum(1 for value in values if value)} of {len(values)}"


def _limit_cell(table: FigureTable, scenario: str, law: str) -> str:
    ratio = _cell(table.spread("limit_ratio", scenario, law), digits=4)
    return f"{_share(table, scenario, law)}: {ratio}"


def _milliseconds(value: float | None) -> str:
    return ABSENT if value is None else shown(1e3 * value, 2)


_PAIR = "without | with the guard"
_AWAY = "{} distance from the reference over {:g}–{:g} s [mm]"
_E1 = "mean |e₁| over {:g}–{:g} s [mm]"


@dataclass(frozen=True, slots=True)
class _ComparedColumn:
    """A figure of the comparison; ``before``: it is told only where a change at 40 s follows."""

    figure: str
    label: str
    factor: float = 1.0
    before: bool = False


_COMPARED = (
    _ComparedColumn(AWAY, _AWAY.format("RMS", *LATE), 1e3),
    _ComparedColumn(FARTHEST, _AWAY.format("largest", *LATE), 1e3),
    _ComparedColumn(E1, _E1.format(*LATE), 1e3),
    _ComparedColumn(
        E1_BEFORE, f"{_E1.format(*BEFORE)}, before the change of parameters", 1e3, before=True
    ),
    _ComparedColumn("ise_total", "ISE over the whole run [m² s + rad² s]"),
    _ComparedColumn("tau_peak", "peak wheel torque [N m]"),
)


def comparison_tables(rows: FigureTable, base: str) -> tuple[TextTable, ...]:
    """All tables of a base case; the best law of a row is that with the guard."""
    runs = f"runs that broke a limit, and the median number of plant steps beyond it; {_PAIR}"
    clip = "share of samples in which the guard changed the force, thrust and moment [%]; median"
    cases = rows.scenarios(base)
    return (
        _table(rows, cases, runs, lambda law, case: _pair(rows, base, case, law, _broken)),
        *(_median_table(rows, base, column) for column in _COMPARED),
        _table(
            rows,
            cases,
            clip,
            lambda law, case: clip_shares(rows.of(case, law, base=base, guard=True)),
        ),
    )


def _median_table(rows: FigureTable, base: str, column: _ComparedColumn) -> TextTable:
    def value(runs: Sequence[RunRow]) -> float | None:
        return median(row[column.figure] for row in runs)

    def cell(runs: Sequence[RunRow]) -> str:
        middle = value(runs)
        return _refused(runs) or shown(None if middle is None else column.factor * middle)

    cases = [
        case
        for case in rows.scenarios(base)
        if not column.before or "changes" not in overrides_of(base, case)
    ]
    best = tuple(
        least([value(rows.of(case, law, base=base, guard=True)) for law in rows.laws])
        for case in cases
    )
    text = f"{column.label}; median, {_PAIR}; marked: the least with the guard"
    return _table(rows, cases, text, lambda law, case: _pair(rows, base, case, law, cell), best)


def _table(
    rows: FigureTable,
    cases: Sequence[str],
    text: str,
    cell: Callable[[str, str], str],
    best: tuple[frozenset[int], ...] = (),
) -> TextTable:
    head = ("case", *map(headed, rows.laws))
    body = tuple((case, *(cell(law, case) for law in rows.laws)) for case in cases)
    return TextTable(f"{text[0].upper()}{text[1:]}", head, body, best)


def _pair(
    rows: FigureTable,
    base: str,
    case: str,
    law: str,
    cell: Callable[[Sequence[RunRow]], str],
) -> str:
    return " | ".join(cell(rows.of(case, law, base=base, guard=guard)) for guard in (False, True))


def _broken(runs: Sequence[RunRow]) -> str:
    count = sum(1 for row in runs if row.broke)
    if not runs or _refused(runs) or not count:
        return _refused(runs) or (f"0/{len(runs)}" if runs else ABSENT)
    ended = any(row.outcome in (Outcome.DIVERGED, Outcome.NON_FINITE) for row in runs)
    steps = median(row["violations"] for row in runs if row.broke) or 0.0
    return f"{count}/{len(runs)}: {'diverged' if ended else f'{steps:.0f}'}"


def clip_shares(runs: Sequence[RunRow]) -> str:
    """Median share of samples in which the guard changed thrust and moment [%], as a cell."""
    first, second = (median(row[f"guard_share{axis}"] for row in runs) for axis in (1, 2))
    if first is None or second is None:
        return _refused(runs) or ABSENT
    return f"{shown(100 * first, 2)}, {shown(100 * second, 2)}"


def _refused(runs: Sequence[RunRow]) -> str:
    return REFUSED if runs and all(row.outcome == REFUSED for row in runs) else ""
