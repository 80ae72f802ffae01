"""The report's tables as plain rows of text."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from wmr_ctrl.campaign import FigureTable, Spread, figure_named
from wmr_ctrl.campaign.comparison import (
    AFTER,
    BEFORE,
    REFUSED,
    ComparedFigure,
    ComparedRun,
    GuardComparison,
    e1_after_of,
    e1_before_of,
    ise_of,
    median,
    position_max_of,
    position_rms_of,
    tau_peak_of,
)
from wmr_ctrl.report.claims import PAPER_TIMES
from wmr_ctrl.report.style import ABSENT, look, shown, unit_text
from wmr_ctrl.results import Outcome


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table for readers: what it shows, its headings, and rows whose first cell names them."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


_W = ((30, 40), (40, 45), (70, 80))
_KILO = {"m": "mm", "rad": "mrad"}
"""Units in which errors are short to read; the files keep metres and radians."""

_TRACKING = (
    ("ise_total", "ISE, 0–80 s"),
    ("ise_before", "ISE, 0–40 s"),
    ("ise_after", "ISE, 40–80 s"),
    ("ise_position", "ISE without θ"),
    *((f"e1_rms_{a}_{b}", f"RMS e₁, {a}–{b} s") for a, b in _W),
    *((f"e2_rms_{a}_{b}", f"RMS e₂, {a}–{b} s") for a, b in _W),
    *((f"e3_rms_{a}_{b}", f"RMS e₃, {a}–{b} s") for a, b in _W),
    *((f"d_rms_{a}_{b}", f"RMS distance, {a}–{b} s") for a, b in _W),
)
_EFFORT = (
    ("max_abs_v1", "largest |v₁|"),
    ("max_abs_omega", "largest |ω|"),
    ("tau_peak", "peak wheel torque"),
    ("tau_rms", "RMS wheel torque, 2–80 s"),
    ("V1_rises", "rises of V₁ in the 4000 samples up to 40 s"),
    ("W1_end", "‖W₁‖ at the end"),
    ("W2_end", "‖W₂‖ at the end"),
)


def scenario_table(table: FigureTable, scenario: str, caption: str) -> TextTable:
    """Median and range of the chief figures of a scenario, a column per law."""
    laws = table.laws
    rows = [
        (_named(name, label), *(_figure(table, name, scenario, law) for law in laws))
        for name, label in (*_TRACKING, *_EFFORT)
    ]
    shares = tuple(_share(table, scenario, law) for law in laws)
    place = len(_TRACKING) + 2
    rows.insert(place, ("seeds that broke a limit", *shares))
    return TextTable(caption, ("", *(look(law).label for law in laws)), tuple(rows))


def stress_table(table: FigureTable, scenarios: Mapping[str, str]) -> TextTable:
    """Share of seeds beyond the limit and the largest |v|/limit, per case and law."""
    rows = tuple(
        (title, *(_limit_cell(table, scenario, law) for law in table.laws))
        for scenario, title in scenarios.items()
    )
    head = ("case", *(look(law).label for law in table.laws))
    caption = "Seeds that broke a limit, and the largest |v|/limit: median (least … greatest)"
    return TextTable(caption, head, rows)


def times_table(times: Mapping[str, float], laws: Sequence[str]) -> TextTable:
    """Seconds per 10,000 evaluations: the paper's and ours, side by side."""
    rows = tuple(
        (look(law).label, _seconds(PAPER_TIMES.get(law)), _seconds(times.get(law))) for law in laws
    )
    return TextTable(
        "Seconds for 10,000 evaluations of the law",
        ("law", "paper (MATLAB, i5-3210M)", "here (compiled C, called from Python)"),
        rows,
    )


def _named(name: str, label: str) -> str:
    unit = figure_named(name).unit
    shown_unit = _KILO.get(unit, unit_text(unit))
    return f"{label} [{shown_unit}]" if shown_unit else label


def _figure(table: FigureTable, name: str, scenario: str, law: str) -> str:
    factor = 1000 if figure_named(name).unit in _KILO else 1
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


def _seconds(value: float | None) -> str:
    return ABSENT if value is None else shown(value, 4)


_PAIR = "without | with the guard"
_AWAY = "{} distance from the reference over {:g}–{:g} s, after the change of parameters [mm]"
_E1 = "mean |e₁| over {:g}–{:g} s"


@dataclass(frozen=True, slots=True)
class _ComparedColumn:
    figure: ComparedFigure
    label: str
    factor: float = 1.0


_COMPARED = (
    _ComparedColumn(position_rms_of, _AWAY.format("RMS", *AFTER), 1e3),
    _ComparedColumn(position_max_of, _AWAY.format("largest", *AFTER), 1e3),
    _ComparedColumn(e1_after_of, f"{_E1.format(*AFTER)}, after the change of parameters [mm]", 1e3),
    _ComparedColumn(e1_before_of, f"{_E1.format(*BEFORE)}, before it [mm]", 1e3),
    _ComparedColumn(ise_of, "ISE over the whole run [m² s + rad² s]"),
    _ComparedColumn(tau_peak_of, "peak wheel torque [N m]"),
)


def comparison_tables(rows: GuardComparison, base: str) -> tuple[TextTable, ...]:
    """All tables of a base case."""
    runs = f"runs that broke a limit, and the median number of plant steps beyond it; {_PAIR}"
    clip = "share of samples in which the guard changed the force, thrust and moment [%]; median"
    return (
        _table(rows, base, runs, lambda law, case: _pair(rows, base, case, law, _broken)),
        *(_median_table(rows, base, column) for column in _COMPARED),
        _table(rows, base, clip, lambda law, case: _clip(rows.of(base, case, law, True))),
    )


def _median_table(rows: GuardComparison, base: str, column: _ComparedColumn) -> TextTable:
    def cell(runs: Sequence[ComparedRun]) -> str:
        value = median(column.figure(row) for row in runs)
        return _refused(runs) or shown(None if value is None else column.factor * value)

    return _table(
        rows,
        base,
        f"{column.label}; median, {_PAIR}",
        lambda law, case: _pair(rows, base, case, law, cell),
    )


def _table(
    rows: GuardComparison, base: str, text: str, cell: Callable[[str, str], str]
) -> TextTable:
    head = ("case", *(look(law).label for law in rows.laws))
    body = tuple((case, *(cell(law, case) for law in rows.laws)) for case in rows.factors(base))
    return TextTable(f"{text[0].upper()}{text[1:]}", head, body)


def _pair(
    rows: GuardComparison,
    base: str,
    case: str,
    law: str,
    cell: Callable[[Sequence[ComparedRun]], str],
) -> str:
    return " | ".join(cell(rows.of(base, case, law, guard)) for guard in (False, True))


def _broken(runs: Sequence[ComparedRun]) -> str:
    count = sum(1 for row in runs if row.broke)
    if not runs or _refused(runs) or not count:
        return _refused(runs) or (f"0/{len(runs)}" if runs else ABSENT)
    ended = any(row.outcome in (Outcome.DIVERGED, Outcome.NON_FINITE) for row in runs)
    steps = median(row.violations for row in runs if row.broke) or 0.0
    return f"{count}/{len(runs)}: {'diverged' if ended else f'{steps:.0f}'}"


def _clip(runs: Sequence[ComparedRun]) -> str:
    shares = [row.clipped for row in runs if row.clipped is not None]
    if _refused(runs) or not shares:
        return _refused(runs) or ABSENT
    first, second = (100 * share for share in _medians(shares))
    return f"{shown(first, 2)}, {shown(second, 2)}"


def _medians(shares: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return median(s[0] for s in shares) or 0.0, median(s[1] for s in shares) or 0.0


def _refused(runs: Sequence[ComparedRun]) -> str:
    return REFUSED if runs and all(row.outcome == REFUSED for row in runs) else ""
