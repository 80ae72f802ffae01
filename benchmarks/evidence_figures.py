"""Figures beyond Fig. 3 and Fig. 5: effects that one ISE hides, and limits of the guarantee."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmr_ctrl.report import drawing
from wmr_ctrl.report.style import INK, LIMIT, MUTED, look, shown
from wmr_ctrl.results import Floats, Run
from wmr_ctrl.results.table import RunTable, median, ratios
from wmr_ctrl.results.windows import LATE, named, seconds
from wmr_ctrl.simulation.campaign import Campaign

from . import marks

Runs: TypeAlias = Mapping[tuple[str, str], Run]
"""First runs by scenario and law."""
LAWS = ("mb", "nn")
WITH, WITHOUT = "paper-simulation", "paper-simulation-no-switch"
_TALL = 2.05


def evidence_figures(campaign: Campaign) -> tuple[drawing.Drawing, ...]:
    """Every figure, in the report's order."""
    table, runs = campaign.table, campaign.runs
    high = 0.9 + 0.07 * len(table.different("case")) * len(table.laws)
    return (
        drawing.Drawing("measure", (9.6, 2.6), partial(_draw_measure, table=table)),
        drawing.Drawing("limits_all_seeds", (9.6, high), partial(_draw_limits, table=table)),
        drawing.Drawing(
            "stress_velocities", (9.6, 2 * _TALL + 0.55), partial(_draw_stress, runs=runs)
        ),
    )


# -- ISE and late e1 of every seed, with and without the change of parameters ---------------


def _draw_measure(figure: Figure, table: RunTable) -> None:
    padding = drawing.Padding(left=0.60, right=0.62, bottom=0.42, top=0.62)
    left, right = drawing.row_of_axes(figure, padding, (1, 1), 0.95)
    late = f"RMS of $e_1$ over {seconds(*LATE)} [mm]"
    _panel_measure(left, table, "ise_total", "whole-run ISE [m² s + rad² s]")
    _panel_measure(right, table, f"e1_rms_{named(LATE)}", late, 1e3)
    handles = [
        marks.dot_handle("parameters change at 40 s"),
        marks.dot_handle("the same seeds without the change", face="white"),
    ]
    drawing.heading(figure, "What the change at 40 s does, in two measures", handles, 0.26)


def _panel_measure(axes: Axes, table: RunTable, name: str, label: str, factor: float = 1.0) -> None:
    marks.law_rows(axes, table.laws)
    axes.set(xscale="log", xlabel=label)
    drawing.plain_ticks(axes)
    for row, law in enumerate(table.laws):
        changed, same = (table.case(case, law) for case in (WITH, WITHOUT))
        for runs, shift, filled in ((changed, -0.2, True), (same, 0.2, False)):
            marks.dots(axes, factor * runs[name], row + shift, law, filled=filled)
        grown = median(ratios(changed.by_seed(name), same.by_seed(name)).values())
        axes.annotate("" if grown is None else f"× {shown(grown)}", (1, row),
                      xycoords=("axes fraction", "data"), xytext=(6, 0),
                      textcoords="offset points", va="center", size=8, weight="bold",
                      color=INK)  # fmt: skip
    axes.annotate("factor", (1, 1), xycoords="axes fraction", xytext=(6, 4), va="bottom",
                  textcoords="offset points", size=6.5, color=MUTED)  # fmt: skip


# -- largest |v|/limit of the worse axis, every scenario, law and seed ------------------------


def _draw_limits(figure: Figure, table: RunTable) -> None:
    axes = drawing.one_axes(figure, drawing.Padding(left=2.30, right=0.20, bottom=0.44, top=0.50))
    scenarios = table.different("case")
    marks.rows_of(axes, scenarios)
    step = 0.84 / len(table.laws)
    for scenario, law in table.cases:
        row, place = scenarios.index(scenario), table.laws.index(law)
        height = row - 0.42 + step * (place + 0.5)
        marks.dots(axes, table.case(scenario, law)["limit_ratio"], height, law, step)
    axes.set(xscale="log", xlabel="largest |v| / limit, worse axis")
    axes.set_xlim(0.5, max(10.0, 1.4 * axes.dataLim.x1))
    drawing.plain_ticks(axes)
    marks.shade_beyond(axes, 1.0)
    title = "How near to the velocity limit, or how far beyond it"
    drawing.heading(figure, title, marks.law_marks(table.laws))


# -- the worse axis' |v|/limit over time in the stress cases, MB and NN -----------------------

_CEILING = 2.0


@dataclass(frozen=True)
class _StressCase:
    """A scenario, the title of its axes, the time shown [s], and whether e1 is shown."""

    scenario: str
    title: str
    end: float = 15.0
    error: bool = False

    def values(self, run: Run) -> Floats:
        """Share of the limit that is used, or e1 [m]."""
        return run["e[1]"] if self.error else 1.0 - run["margin"]


_ROWS = (
    (
        _StressCase("far-start", "Far start, exact model"),
        _StressCase("far-start-friction-overestimated", "…, friction believed 50 % too high"),
        _StressCase("far-start-drop", "…, mass and friction drop at 3 s"),
    ),
    (
        _StressCase("outside-start", "Start outside the limits"),
        _StressCase("paper-experiment-literal", "Torque held for 100 ms"),
        _StressCase("fast-reference", "Reference at 0.9 m/s: e₁ [m]", 80.0, error=True),
    ),
)


def _draw_stress(figure: Figure, runs: Runs) -> None:
    _, height = figure.get_size_inches()
    ratios = (height - 2 * _TALL, _TALL, _TALL)
    grid = figure.add_gridspec(3, 1, height_ratios=ratios, hspace=0.0)
    padding = drawing.Padding(left=0.56, right=0.14, bottom=0.44, top=0.26)
    for index, cases in enumerate(_ROWS):
        part = figure.add_subfigure(grid[index + 1, 0])
        row = drawing.row_of_axes(part, padding, (1, 1, 1), 0.42)
        for axes, case in zip(row, cases, strict=True):
            _panel_stress(axes, case, {law: runs[case.scenario, law] for law in LAWS})
        row[0].set_ylabel("|v| / limit, worse axis")
    drawing.heading(figure, "Where the guarantee ends", marks.law_handles(LAWS))


def _panel_stress(axes: Axes, case: _StressCase, runs: Mapping[str, Run]) -> None:
    """Draw a case over time, with an arrow for each law that leaves the axes."""
    axes.set_title(case.title, size=8, weight="normal", pad=3)
    for place, (law, run) in enumerate(runs.items()):
        seen, y = look(law), case.values(run)
        rows = slice(0, run.settings.index(case.end))
        axes.plot(run.time[rows], y[rows], color=seen.colour, lw=1.0)
        worst = float(np.nanmax(y))
        if worst > _CEILING and not case.error:
            axes.annotate(f"{seen.label}: ↑ to {worst:.3g}", (1, 1 - 0.1 * place),
                          xycoords="axes fraction", xytext=(-3, -4), ha="right", va="top",
                          textcoords="offset points", size=7, color=MUTED)  # fmt: skip
    axes.set(xlabel="t [s]", xlim=(0, case.end))
    if not case.error:
        axes.set_ylim(0, _CEILING)
        axes.axhspan(1, _CEILING, color=LIMIT, alpha=0.10, lw=0)
        axes.axhline(1, color=LIMIT, lw=0.9)
