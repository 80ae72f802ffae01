"""Where the guarantee ends: how near to its velocity limit, or how far beyond it, each run came."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmr_ctrl.campaign import Campaign, FigureTable
from wmr_ctrl.report.drawing import (
    Drawing,
    Padding,
    dots,
    heading,
    law_handles,
    law_marks,
    legend_row,
    one_axes,
    plain_ticks,
    row_of_axes,
    rows_of,
    thin,
)
from wmr_ctrl.report.style import LIMIT, MUTED, look
from wmr_ctrl.results import FloatArray, Run

STRESS = ("limits_all_seeds", "stress_velocities")
"""Names of the figures, in the report's order."""


def guarantee_figures(campaign: Campaign) -> tuple[Drawing, ...]:
    """Every figure of :data:`STRESS`, in their order."""
    return limits_drawing(campaign), stress_drawing(campaign)


def limits_drawing(campaign: Campaign) -> Drawing:
    """Largest |v|/limit of the worse axis, every scenario, law and seed."""
    count = len(campaign.table.scenarios()) * len(campaign.table.laws)
    return Drawing(
        "limits_all_seeds",
        "How far each run went towards its velocity limit, or beyond",
        "Largest |v|/limit over both axes and the whole run; one mark per seed. Left of the line "
        "the limit was kept. SMC’s far starts end in divergence (|v| ≥ 1000).",
        (9.6, 0.9 + 0.07 * count),
        partial(_draw_limits, table=campaign.table),
    )


def _draw_limits(figure: Figure, table: FigureTable) -> None:
    axes = one_axes(figure, Padding(left=2.30, right=0.20, bottom=0.44, top=0.50))
    rows_of(axes, table.scenarios())
    step = 0.84 / len(table.laws)
    for row, scenario in enumerate(table.scenarios()):
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


LAWS = ("mb", "nn")
_CEILING = 2.0
_TALL = 2.05


@dataclass(frozen=True, slots=True)
class _StressCase:
    """A scenario, what stands above its axes, how long it is shown [s], and what of it."""

    scenario: str
    title: str
    end: float
    error: bool = False


_ROWS = (
    (
        _StressCase("far-start", "Far start, exact model", 15.0),
        _StressCase("far-start-friction-overestimated", "…, friction believed 50 % too high", 15.0),
        _StressCase("far-start-drop", "…, mass and friction drop at 3 s", 15.0),
    ),
    (
        _StressCase("outside-start", "Start outside the limits", 15.0),
        _StressCase("paper-experiment-literal", "Torque held for 100 ms", 15.0),
        _StressCase("fast-reference", "Reference at 0.9 m/s: e₁ [m]", 80.0, error=True),
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
        partial(_draw_stress, runs=campaign.runs),
    )


def _draw_stress(figure: Figure, runs: Mapping[tuple[str, str], Run]) -> None:
    _, height = figure.get_size_inches()
    ratios = (height - 2 * _TALL, _TALL, _TALL)
    grid = figure.add_gridspec(3, 1, height_ratios=ratios, hspace=0.0)
    padding = Padding(left=0.56, right=0.14, bottom=0.44, top=0.26)
    for index, cases in enumerate(_ROWS):
        part = figure.add_subfigure(grid[index + 1, 0])
        row = row_of_axes(part, padding, (1, 1, 1), 0.42)
        for axes, case in zip(row, cases, strict=True):
            _panel(axes, case, runs)
        row[0].set_ylabel("|v| / limit, worse axis")
    heading(figure, "Where the guarantee ends")
    legend_row(figure, law_handles(LAWS))


def _panel(axes: Axes, case: _StressCase, runs: Mapping[tuple[str, str], Run]) -> None:
    for law in LAWS:
        run = runs[case.scenario, law]
        rows = slice(0, run.settings.index(case.end))
        seen, y = look(law), _value(run, case)[rows]
        axes.plot(*thin(run.time[rows], y), color=seen.colour, lw=1.0)
    axes.set_title(case.title, size=8, weight="normal", pad=3)
    axes.set(xlabel="t [s]", xlim=(0, case.end))
    if not case.error:
        _limit(axes, case, runs)


def _value(run: Run, case: _StressCase) -> FloatArray:
    return run["e[1]"] if case.error else 1.0 - run["margin"]


def _limit(axes: Axes, case: _StressCase, runs: Mapping[tuple[str, str], Run]) -> None:
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
