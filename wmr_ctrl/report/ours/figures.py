"""Figures of the comparison: violations, e1 after the switch, and ISE against T and tau_max."""

from __future__ import annotations

from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wmr_ctrl.campaign.ours_run import AFTER
from wmr_ctrl.report.canvas import Margins, heading, legend_row, row_of_axes
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras.dots import dots, plain_ticks, rows_of, seed_handle
from wmr_ctrl.report.extras.limits import law_marks
from wmr_ctrl.report.ours.rows import BASE, Rows
from wmr_ctrl.report.ours.sweeps import period_drawing, torque_drawing
from wmr_ctrl.report.style import LIMIT, MUTED, look


def our_figures(rows: Rows) -> tuple[Drawing, ...]:
    """Every figure of the comparison, in the section's order."""
    return (_violations(rows), _e1_after(rows), period_drawing(rows), torque_drawing(rows))


def title_of(base: str) -> str:
    """How a base case is called above its axes."""
    return f"torque held for {base}"


def _violations(rows: Rows) -> Drawing:
    count = len(rows.factors()) * len(rows.laws)
    return Drawing(
        "ours_violations",
        "Plant steps beyond a limit, without and with the guard",
        "One mark per run. Filled: without the guard; hollow: with it. Guarded runs leave the "
        "limits only where they start outside. Runs that diverge end early and so count few "
        "steps; cases that the guard refuses have no hollow marks.",
        (9.6, 1.1 + 0.07 * count),
        partial(_draw_violations, rows=rows),
    )


def _draw_violations(figure: Figure, rows: Rows) -> None:
    margins, factors = Margins(left=2.75, right=0.15, bottom=0.44, top=0.74), rows.factors()
    panels = row_of_axes(figure, margins, [1.0] * len(rows.bases), 0.2)
    for place, (axes, base) in enumerate(zip(panels, rows.bases, strict=True)):
        rows_of(axes, factors if place == 0 else [""] * len(factors))
        _fill(axes, rows, base)
        axes.set_title(title_of(base), weight="normal", size=8)
        axes.set(xscale="symlog", xlabel="plant steps beyond a limit", xlim=(-0.6, 2e5))
        axes.set_xticks(
            [0, 1, 10, 100, 1000, 1e4, 1e5], ["0", "1", "10", "100", "10³", "10⁴", "10⁵"]
        )
        axes.axvspan(0.5, 2e5, color=LIMIT, alpha=0.07, lw=0)
    heading(figure, "Plant steps beyond a velocity limit")
    legend_row(figure, [*law_marks(rows.laws), *_kinds()])


def _fill(axes: Axes, rows: Rows, base: str) -> None:
    step = 0.84 / len(rows.laws)
    for row, factor in enumerate(rows.factors()):
        if factor not in rows.factors(base):
            axes.annotate("first base only", (0, row), xytext=(12, 0), textcoords="offset points",
                          va="center", size=6.5, color=MUTED)  # fmt: skip
        for place, law in enumerate(rows.laws):
            height = row - 0.42 + step * (place + 0.5)
            for guard in (False, True):
                found = [r.violations for r in rows.of(base, factor, law, guard) if r.speed]
                dots(axes, found, height, law, step, filled=not guard)


def _e1_after(rows: Rows) -> Drawing:
    return Drawing(
        "ours_e1_after",
        f"e₁ after the change of parameters, mean over {AFTER[0]:g}–{AFTER[1]:g} s",
        "The base cases; each mark is a seed, each bar a median.",
        (9.6, 0.95 + 0.36 * len(rows.laws)),
        partial(_draw_e1, rows=rows),
    )


def _draw_e1(figure: Figure, rows: Rows) -> None:
    margins = Margins(left=0.60, right=0.15, bottom=0.42, top=0.74)
    panels = row_of_axes(figure, margins, [1.0] * len(rows.bases), 0.55)
    for axes, base in zip(panels, rows.bases, strict=True):
        rows_of(axes, [look(law).label for law in rows.laws])
        for row, law in enumerate(rows.laws):
            for guard in (False, True):
                found = [
                    None if r.e1_after is None else 1e3 * r.e1_after
                    for r in rows.of(base, BASE, law, guard)
                ]
                dots(axes, found, row + (0.2 if guard else -0.2), law, filled=not guard)
        axes.set(xscale="log", xlabel=r"mean $|e_1|$ [mm]", xlim=(0.1, 2000.0))
        plain_ticks(axes, (1,))
        axes.set_title(title_of(base), weight="normal", size=8)
    heading(figure, f"$e_1$ after the change of parameters, {AFTER[0]:g}–{AFTER[1]:g} s")
    legend_row(figure, _kinds())


def _kinds() -> list[Line2D]:
    return [seed_handle("without the guard", filled=True), seed_handle("with it", filled=False)]
