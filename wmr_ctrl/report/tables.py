"""The report's tables as plain rows of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from wmr_ctrl.campaign import Spread, Table, figure_named
from wmr_ctrl.report.claims import PAPER_TIMES
from wmr_ctrl.report.style import look, unit_text
from wmr_ctrl.report.wording import ABSENT, shown


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


def scenario_table(table: Table, scenario: str, caption: str) -> TextTable:
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


def stress_table(table: Table, scenarios: Mapping[str, str]) -> TextTable:
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


def _figure(table: Table, name: str, scenario: str, law: str) -> str:
    factor = 1000 if figure_named(name).unit in _KILO else 1
    return _cell(table.spread(name, scenario, law), factor)


def _cell(found: Spread, factor: float = 1, digits: int = 3) -> str:
    if found.median is None or found.min is None or found.max is None:
        return ABSENT
    middle, low, high = (shown(factor * x, digits) for x in (found.median, found.min, found.max))
    return middle if low == high else f"{middle} ({low} … {high})"


def _share(table: Table, scenario: str, law: str) -> str:
    values = table.values("violated", scenario, law).values()
    return f"{sum(1 for value in values if value)} of {len(values)}"


def _limit_cell(table: Table, scenario: str, law: str) -> str:
    ratio = _cell(table.spread("limit_ratio", scenario, law), digits=4)
    return f"{_share(table, scenario, law)}: {ratio}"


def _seconds(value: float | None) -> str:
    return ABSENT if value is None else shown(value, 4)
