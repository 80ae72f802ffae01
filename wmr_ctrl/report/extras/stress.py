"""Velocities against their limit where the guarantee ends, and the reference too fast for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmr_ctrl.campaign import Campaign
from wmr_ctrl.report.canvas import Margins, heading, law_handles, legend_row, row_of_axes
from wmr_ctrl.report.decimate import thin
from wmr_ctrl.report.drawing import Drawing
from wmr_ctrl.report.style import LIMIT, MUTED, look
from wmr_ctrl.results import FloatArray, Run

LAWS = ("mb", "nn")
_CEILING = 2.0
_TALL = 2.05


@dataclass(frozen=True, slots=True)
class _Case:
    """A scenario, what stands above its axes, how long it is shown [s], and what of it."""

    scenario: str
    title: str
    end: float
    error: bool = False


_ROWS = (
    (
        _Case("far-start", "Far start, exact model", 15.0),
        _Case("far-start-friction-overestimated", "…, friction believed 50 % too high", 15.0),
        _Case("far-start-drop", "…, mass and friction drop at 3 s", 15.0),
    ),
    (
        _Case("outside-start", "Start outside the limits", 15.0),
        _Case("paper-experiment-literal", "Torque held for 100 ms", 15.0),
        _Case("fast-reference", "Reference at 0.9 m/s: e₁ [m]", 80.0, error=True),
    ),
)


def stress_drawing(campaign: Campaign) -> Drawing:
    """Worse axis' |v|/limit over time in the stress cases, MB and NN."""
    return Drawing(
        "stress_velocities",
        "Where the guarantee ends: MB and NN",
        "Share of the velocity limit in use, worse axis, first seed; the shaded region is beyond "
        "the limit, an arrow says how far a trace goes that leaves the axes. The last axes show "
        "the error e₁, since there the limits hold and the tracking fails.",
        (9.6, 2 * _TALL + 0.55),
        partial(_draw, runs=campaign.runs),
    )


def _draw(figure: Figure, runs: Mapping[tuple[str, str], Run]) -> None:
    _, height = figure.get_size_inches()
    ratios = (height - 2 * _TALL, _TALL, _TALL)
    grid = figure.add_gridspec(3, 1, height_ratios=ratios, hspace=0.0)
    margins = Margins(left=0.56, right=0.14, bottom=0.44, top=0.26)
    for index, cases in enumerate(_ROWS):
        part = figure.add_subfigure(grid[index + 1, 0])
        row = row_of_axes(part, margins, (1, 1, 1), 0.42)
        for axes, case in zip(row, cases, strict=True):
            _panel(axes, case, runs)
        row[0].set_ylabel("|v| / limit, worse axis")
    heading(figure, "Where the guarantee ends")
    legend_row(figure, law_handles(LAWS))


def _panel(axes: Axes, case: _Case, runs: Mapping[tuple[str, str], Run]) -> None:
    for law in LAWS:
        run = runs[case.scenario, law]
        rows = slice(0, run.settings.index(case.end))
        seen, y = look(law), _value(run, case)[rows]
        axes.plot(*thin(run.time[rows], y), color=seen.colour, lw=1.0)
    axes.set_title(case.title, size=8, weight="normal", pad=3)
    axes.set(xlabel="t [s]", xlim=(0, case.end))
    if not case.error:
        _limit(axes, case, runs)


def _value(run: Run, case: _Case) -> FloatArray:
    return run["e[1]"] if case.error else 1.0 - run["margin"]


def _limit(axes: Axes, case: _Case, runs: Mapping[tuple[str, str], Run]) -> None:
    """The limit's line and shade; an arrow for each law that leaves the axes."""
    axes.set_ylim(0, _CEILING)
    axes.axhspan(1, _CEILING, color=LIMIT, alpha=0.10, lw=0)
    axes.axhline(1, color=LIMIT, lw=0.9)
    for place, law in enumerate(LAWS):
        worst = float(np.nanmax(_value(runs[case.scenario, law], case)))
        if worst > _CEILING:
            axes.annotate(f"{look(law).label}: ↑ to {worst:.3g}", (1, 1 - 0.1 * place),
                          xycoords="axes fraction", xytext=(-3, -4), ha="right", va="top",
                          textcoords="offset points", size=7, color=MUTED)  # fmt: skip
