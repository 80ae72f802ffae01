"""e1 around the change of parameters, beside the same run without the change."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wmr_ctrl.campaign import Campaign
from wmr_ctrl.report.canvas import (
    Margins,
    heading,
    legend_row,
    mark_switch,
    row_of_axes,
    switch_handle,
)
from wmr_ctrl.report.decimate import running_rms, thin
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.extras.measure import WITH, WITHOUT
from wmr_ctrl.report.panels.base import switch_time
from wmr_ctrl.report.style import INK, MUTED, look
from wmr_ctrl.results import Run

_FROM = 20.0
_MEAN = 1.0

Runs = Mapping[tuple[str, str], Run]


def switch_drawing(campaign: Campaign) -> Drawing:
    """Running RMS of e1 with and without the change, one small panel per law."""
    return Drawing(
        "switch",
        "The error along the robot’s heading, with the change and without",
        "RMS of e₁ over a sliding second, first seed. SMC recovers fully and NN most of the way; "
        "MB keeps an offset of 1.5 cm, PID one of 4.5 cm where it had 1.9 cm before.",
        (9.6, 2.5),
        partial(_draw, runs=campaign.runs, laws=campaign.table.laws),
    )


def _draw(figure: Figure, runs: Runs, laws: tuple[str, ...]) -> None:
    margins = Margins(left=0.62, right=0.12, bottom=0.42, top=0.64)
    row = row_of_axes(figure, margins, (1,) * len(laws), 0.16)
    for axes, law in zip(row, laws, strict=True):
        _panel(axes, law, runs)
        if axes is not row[0]:
            axes.tick_params(labelleft=False)
    row[0].set_ylabel("RMS of $e_1$ over 1 s [m]")
    _share_range(row)
    heading(figure, "What the change at 40 s does to the error along the heading")
    time = switch_time(runs[WITH, laws[0]])
    handles = [
        Line2D([], [], color=INK, lw=1.4, label="with the change"),
        Line2D([], [], color=MUTED, lw=1.0, label="without it, same noise"),
        *([switch_handle(time)] if time is not None else []),
    ]
    legend_row(figure, handles, 0.26)


def _panel(axes: Axes, law: str, runs: Runs) -> None:
    changed, same = runs[WITH, law], runs[WITHOUT, law]
    axes.plot(*_trace(same), color=MUTED, lw=0.9)
    axes.plot(*_trace(changed), color=look(law).colour, lw=1.4)
    axes.set(yscale="log", xlabel="t [s]", xlim=(_FROM, changed.settings.duration))
    axes.set_xticks((30, 40, 50, 60, 70))
    axes.set_title(look(law).label, color=look(law).colour, pad=3)
    mark_switch(axes, switch_time(changed))


def _trace(run: Run) -> tuple[np.ndarray, np.ndarray]:
    rows = slice(run.settings.index(_FROM), None)
    rms = running_rms(run["e[1]"], max(1, round(_MEAN / run.settings.control)))
    return thin(run.time[rows], np.maximum(rms[rows], 1e-6), 600)


def _share_range(row: tuple[Axes, ...]) -> None:
    low = min(axes.get_ylim()[0] for axes in row)
    high = max(axes.get_ylim()[1] for axes in row)
    for axes in row:
        axes.set_ylim(low, high)
