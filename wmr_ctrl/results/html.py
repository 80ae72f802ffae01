"""Small tables of HTML for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wmr_ctrl.results.run import Run

ABSENT = "–"


def run_html(run: Run) -> str:
    """A run's labels, outcome and main figures."""
    from wmr_ctrl.results.summary import summary

    figures = summary(run)
    position, ise = figures["position_rms"], figures["ise"]
    assert isinstance(position, Mapping)
    assert isinstance(ise, Mapping)
    guarded = ", guarded" if run.guard else ""
    rows = [
        ("outcome", run.outcome.value),
        ("tracked", {None: ABSENT, True: "yes", False: "no"}[_flag(figures["tracked"])]),
        ("position error, RMS [m]", figure(position["all"])),
        ("position error, RMS of the last quarter [m]", figure(position["last_quarter"])),
        ("ISE [m² s + rad² s]", figure(ise["total"])),
        ("largest |v1| [m/s], |omega| [rad/s]", ", ".join(map(figure, run.monitor.max_abs_v))),
        ("largest wheel torque [N m]", figure(figures["tau_peak"])),
        *((remark.key, remark.text) for remark in run.remarks),
    ]
    title = f"{run.law}{guarded} on {run.scenario}, seed {run.seed}, {run.engine} engine"
    return table_html(title, rows)


def table_html(title: str, rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """A titled table; every cell is escaped."""
    head = f"<tr>{''.join(f'<th>{escape(cell)}</th>' for cell in header)}</tr>" if header else ""
    style = "text-align:left;vertical-align:top"
    body = "".join(
        f"<tr>{''.join(f'<td style={style!r}>{escape(cell)}</td>' for cell in row)}</tr>"
        for row in rows
    )
    return f"<div><strong>{escape(title)}</strong><table>{head}{body}</table></div>"


def figure(value: object) -> str:
    """A number with four digits, a text as it is, – for None."""
    if value is None:
        return ABSENT
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _flag(value: object) -> bool | None:
    return None if value is None else bool(value)
