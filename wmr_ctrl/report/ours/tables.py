"""Tables of the comparison: a row per case, a column per law, without and with the guard."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from wmr_ctrl.campaign.ours_run import AFTER, BEFORE, REFUSED, Comparison
from wmr_ctrl.report.ours.rows import Rows, broke, median
from wmr_ctrl.report.style import look
from wmr_ctrl.report.tables import TextTable
from wmr_ctrl.report.wording import ABSENT, shown
from wmr_ctrl.results import Outcome

_PAIR = "without | with the guard"
_E1 = "mean |e₁| over {:g}–{:g} s"


@dataclass(frozen=True, slots=True)
class _Figure:
    name: str
    label: str
    factor: float = 1.0


_FIGURES = (
    _Figure("e1_after", f"{_E1.format(*AFTER)}, after the change of parameters [mm]", 1e3),
    _Figure("e1_before", f"{_E1.format(*BEFORE)}, before it [mm]", 1e3),
    _Figure("ise", "ISE over the whole run [m² s + rad² s]"),
    _Figure("tau_peak", "peak wheel torque [N m]"),
)


def our_tables(rows: Rows, base: str) -> tuple[TextTable, ...]:
    """All tables of a base case."""
    runs = f"runs that broke a limit, and the median number of plant steps beyond it; {_PAIR}"
    clip = "share of samples in which the guard changed the force, thrust and moment [%]; median"
    return (
        _table(rows, base, runs, lambda law, case: _pair(rows, base, case, law, _broken)),
        *(_median_table(rows, base, figure) for figure in _FIGURES),
        _table(rows, base, clip, lambda law, case: _clip(rows.of(base, case, law, True))),
    )


def _median_table(rows: Rows, base: str, figure: _Figure) -> TextTable:
    def cell(found: Sequence[Comparison]) -> str:
        value = median(getattr(row, figure.name) for row in found)
        return _refused(found) or shown(None if value is None else figure.factor * value)

    return _table(
        rows,
        base,
        f"{figure.label}; median, {_PAIR}",
        lambda law, case: _pair(rows, base, case, law, cell),
    )


def _table(rows: Rows, base: str, text: str, cell: Callable[[str, str], str]) -> TextTable:
    head = ("case", *(look(law).label for law in rows.laws))
    body = tuple((case, *(cell(law, case) for law in rows.laws)) for case in rows.factors(base))
    return TextTable(f"{text[0].upper()}{text[1:]}", head, body)


def _pair(
    rows: Rows, base: str, case: str, law: str, cell: Callable[[Sequence[Comparison]], str]
) -> str:
    return " | ".join(cell(rows.of(base, case, law, guard)) for guard in (False, True))


def _broken(found: Sequence[Comparison]) -> str:
    count = sum(map(broke, found))
    if not found or _refused(found) or not count:
        return _refused(found) or (f"0/{len(found)}" if found else ABSENT)
    ended = any(row.outcome in (Outcome.DIVERGED, Outcome.NON_FINITE) for row in found)
    steps = median(row.violations for row in found if broke(row)) or 0.0
    return f"{count}/{len(found)}: {'diverged' if ended else f'{steps:.0f}'}"


def _clip(found: Sequence[Comparison]) -> str:
    shares = [row.clipped for row in found if row.clipped is not None]
    if _refused(found) or not shares:
        return _refused(found) or ABSENT
    first, second = (100 * share for share in _medians(shares))
    return f"{shown(first, 2)}, {shown(second, 2)}"


def _medians(shares: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return median(s[0] for s in shares) or 0.0, median(s[1] for s in shares) or 0.0


def _refused(found: Sequence[Comparison]) -> str:
    return REFUSED if found and all(row.outcome == REFUSED for row in found) else ""
