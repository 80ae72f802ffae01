"""How near to the velocity limit, or how far beyond, every run of every scenario came."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wmr_ctrl.campaign import Campaign, Table
from wmr_ctrl.report.canvas import Margins, heading, legend_row, one_axes
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras.dots import dots, plain_ticks, rows_of
from wmr_ctrl.report.style import LIMIT, look


def limits_drawing(campaign: Campaign) -> Drawing:
    """Largest |v|/limit of the worse axis, every scenario, law and seed."""
    count = len(campaign.table.scenarios) * len(campaign.table.laws)
    return Drawing(
        "limits_all_seeds",
        "How far each run went towards its velocity limit, or beyond",
        "Largest |v|/limit over both axes and the whole run; one mark per seed. Left of the line "
        "the limit was kept. SMC’s far starts end in divergence (|v| ≥ 1000).",
        (9.6, 0.9 + 0.07 * count),
        partial(_draw, table=campaign.table),
    )


def _draw(figure: Figure, table: Table) -> None:
    axes = one_axes(figure, Margins(left=2.30, right=0.20, bottom=0.44, top=0.50))
    rows_of(axes, table.scenarios)
    step = 0.84 / len(table.laws)
    for row, scenario in enumerate(table.scenarios):
        for place, law in enumerate(table.laws):
            if (scenario, law) not in table.cases:
                continue
            height = row - 0.42 + step * (place + 0.5)
            dots(axes, table.values("limit_ratio", scenario, law).values(), height, law, step)
    axes.set(xscale="log", xlabel="largest |v| / limit, worse axis")
    axes.set_xlim(0.5, max(10.0, 1.4 * axes.dataLim.x1))
    plain_ticks(axes, (1, 2, 5))
    axes.axvline(1, color=LIMIT, lw=1.0)
    axes.axvspan(1, axes.get_xlim()[1], color=LIMIT, alpha=0.08, lw=0)
    heading(figure, "How near to the velocity limit, or how far beyond it")
    legend_row(figure, law_marks(table.laws))


def law_marks(laws: Iterable[str]) -> list[Line2D]:
    """One mark per law, as legends of dots want them."""
    seen = [look(law) for law in laws]
    return [
        Line2D([], [], ls="", marker=one.marker, color=one.colour, ms=4, label=one.label)
        for one in seen
    ]
