"""The same change of parameters, seen by the ISE and seen by e1."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmr_ctrl.campaign import Campaign, Table
from wmr_ctrl.report.canvas import Margins, heading, legend_row, row_of_axes
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras.dots import dots, plain_ticks, rows_of, seed_handle
from wmr_ctrl.report.style import INK, MUTED, look
from wmr_ctrl.report.wording import shown

WITH, WITHOUT = "paper-simulation", "paper-simulation-no-switch"
_COLUMNS = (
    ("ise_total", "whole-run ISE [m² s + rad² s]"),
    ("e1_rms_70_80", "RMS of $e_1$ over 70–80 s [m]"),
)


def measure_drawing(campaign: Campaign) -> Drawing:
    """ISE and late e1 of every seed, with and without the change of parameters."""
    return Drawing(
        "measure",
        "The same change of parameters, in two measures",
        "Each mark is a seed, each bar a median. The factor is the median of “with the change” "
        "over “without it”, seed by seed. The ISE over the whole run, the paper’s measure, cannot "
        "tell MB with the change from MB without it; e₁ can.",
        (9.6, 2.6),
        partial(_draw, table=campaign.table),
    )


def _draw(figure: Figure, table: Table) -> None:
    margins = Margins(left=0.60, right=0.62, bottom=0.42, top=0.62)
    for axes, (name, label) in zip(
        row_of_axes(figure, margins, (1, 1), 0.95), _COLUMNS, strict=True
    ):
        _panel(axes, table, name, label)
    heading(figure, "What the change at 40 s does, in two measures")
    handles = [
        seed_handle("parameters change at 40 s", filled=True),
        seed_handle("the same seeds without the change", filled=False),
    ]
    legend_row(figure, handles, 0.26)


def _panel(axes: Axes, table: Table, name: str, label: str) -> None:
    laws = table.laws
    rows_of(axes, [look(law).label for law in laws])
    axes.set(xscale="log", xlabel=label)
    plain_ticks(axes)
    for row, law in enumerate(laws):
        changed, same = (table.values(name, case, law) for case in (WITH, WITHOUT))
        dots(axes, changed.values(), row - 0.2, law)
        dots(axes, same.values(), row + 0.2, law, filled=False)
        axes.annotate(_factor(changed, same), (1, row), xycoords=("axes fraction", "data"),
                      xytext=(6, 0), textcoords="offset points", va="center", size=8,
                      weight="bold", color=INK)  # fmt: skip
    axes.annotate("factor", (1, 1), xycoords="axes fraction", xytext=(6, 4), va="bottom",
                  textcoords="offset points", size=6.5, color=MUTED)  # fmt: skip


def _factor(changed: dict[int, float | None], same: dict[int, float | None]) -> str:
    ratios = [
        value / other
        for seed, value in changed.items()
        if value is not None and (other := same.get(seed))
    ]
    return f"× {shown(float(np.median(ratios)))}" if ratios else ""
