"""Figures of the paper's runs for `wmr-ctrl reproduce`: the twelve panels of Figs. 3 and 5.

Further figures are in `evidence_figures`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from wmr_ctrl.core.data import data, with_tuples
from wmr_ctrl.report import drawing
from wmr_ctrl.report.style import INK, MUTED, look
from wmr_ctrl.results import Floats, Run, distance
from wmr_ctrl.simulation.campaign import Campaign

from . import marks
from .evidence_figures import evidence_figures

Group: TypeAlias = Mapping[str, Run]
"""Runs of one scenario by law, in the order in which they are drawn and named."""
WIDTHS = (1.0, 1.75)
GAP = 0.42
START = 3.0
"""Duration of the enlarged beginning [s]."""
PANEL_SIZE = (4.7, 2.9)


@dataclass(frozen=True)
class Panel:
    """One panel: its letter in the paper, a name for files, a title, and its quantity over time.

    ``column`` and, if given, ``less``: the quantity is their difference; without a column the paths
    are drawn.  ``smooth`` [s]: a running mean of that length over the faint samples.  ``laws``:
    those that have the quantity, if not all.

    With ``whole`` the run is on one scale, from zero, or logarithmic from a ``floor``.  Else its
    start is enlarged for ``early`` [s]; ``limit_axis`` (0 or 1) names the velocity limit to shade,
    and ``late`` fixes the right axes' range.
    """

    letter: str
    key: str
    title: str
    label: str = ""
    column: str = ""
    less: str = ""
    smooth: float = 0.0
    laws: tuple[str, ...] = ()
    whole: bool = False
    floor: float = 0.0
    early: float = 2.0
    limit_axis: int | None = None
    late: tuple[float, float] | None = None

    def of(self, group: Group) -> Group:
        """The runs of ``group`` that this panel shows."""
        return {law: run for law, run in group.items() if not self.laws or law in self.laws}

    def value(self, run: Run) -> Floats:
        """The quantity (N,); errors are true poses less the reference, unlike those of Eq. (8)."""
        if self.column == "distance":
            return 1e3 * distance(run)
        return run[self.column] - run[self.less] if self.less else run[self.column]

    def mean(self, run: Run, values: Floats) -> Floats:
        """Running mean of the quantity."""
        return drawing.running_mean(values, max(1, round(self.smooth / run.settings.control)))


PANELS = tuple(Panel(**with_tuples(row)) for row in data(__package__, "panels.toml")["panel"])
"""Panels (a) to (l)."""


def _draw_parts(figure: Figure, group: Group, panel: Panel) -> None:
    """Draw the enlarged start of every run, and the rest."""
    start, rest = drawing.row_of_axes(figure, drawing.Padding(), WIDTHS, GAP)
    for law, run in group.items():
        seen, cut, t, y = look(law), run.settings.index(panel.early), run.time, panel.value(run)
        start.plot(t[: cut + 1], y[: cut + 1], color=seen.colour, ls=seen.dash)
        t, y, width = t[cut:], y[cut:], 0.9
        if panel.smooth:
            rest.plot(t, y, color=seen.colour, lw=0.5, alpha=0.25)
            y, width = panel.mean(run, y), 1.2
        rest.plot(t, y, color=seen.colour, ls=seen.dash, lw=width, zorder=2.5)
    start.set(xlabel=f"t [s], first {panel.early:g} s", xlim=(0, panel.early), ylabel=panel.label)
    mean_text = f" (line: {panel.smooth:g} s mean)" if panel.smooth else ""
    rest.set(xlabel=f"t [s], from {panel.early:g} s on{mean_text}")
    rest.set_xlim(0, run.settings.duration)
    if panel.late:
        rest.set_ylim(panel.late)
    if panel.limit_axis is not None:
        low, high = run.settings.sides[panel.limit_axis]
        drawing.include(start, (1.1 * low, 1.1 * high))
        drawing.shade_limits(start, low, high)
        drawing.shade_limits(rest, low, high)
    drawing.mark_switch(rest, run.settings)


def _draw_whole(figure: Figure, group: Group, panel: Panel) -> None:
    """Draw every run on one scale."""
    axes = drawing.one_axes(figure, drawing.Padding())
    axes.set(xlabel="t [s]", ylabel=panel.label)
    for law, run in group.items():
        seen, y = look(law), panel.value(run)
        if panel.floor:
            y = np.maximum(y, panel.floor)
            axes.plot(run.time, y, color=seen.colour, lw=0.4, alpha=0.2)
            y = panel.mean(run, y)
            axes.set(xlabel=f"t [s] (faint: samples; line: {panel.smooth:g} s mean)", yscale="log")
        axes.plot(run.time, y, color=seen.colour, ls=seen.dash, zorder=2.5)
    axes.set(xlim=(0, run.settings.duration))
    axes.set_ylim(bottom=panel.floor)
    drawing.mark_switch(axes, run.settings)


def _draw_trajectory(figure: Figure, group: Group) -> None:
    """Paths of all laws with their reference; on the right the first seconds; equal scales."""
    whole, start = drawing.row_of_axes(figure, drawing.Padding(), (1.0, 1.0), 0.6)
    _draw_paths(whole, group, 64)
    low, high = _draw_paths(start, group, 20, START)
    whole.set(xlabel="x [m]", ylabel="y [m]")
    start.set(xlabel=f"x [m], first {START:g} s only", ylabel="y [m]")
    whole.set_aspect("equal", adjustable="datalim")
    half = 0.55 * max(*(high - low), 0.1)
    corner = (low + high) / 2 - half
    start.set(xlim=corner[0] + (0, 2 * half), ylim=corner[1] + (0, 2 * half))
    start.set_aspect("equal", adjustable="box")
    frame = Rectangle(tuple(corner), 2 * half, 2 * half, fill=False, ec=MUTED, lw=0.6, zorder=3)
    whole.add_patch(frame)


def _draw_paths(
    axes: Axes, group: Group, dots: int, end: float | None = None
) -> tuple[Floats, Floats]:
    """Each law's path, the reference as dots on top, and a ring at the robot's start.

    Nothing after ``end`` [s] is drawn.  Returns the least and greatest x, y [m].
    """
    seen = []
    for law, run in group.items():
        rows = slice(None if end is None else run.settings.index(end) + 1)
        path, desired = (run["x"][rows], run["y"][rows]), (run["x_d"][rows], run["y_d"][rows])
        seen += [np.column_stack(path), np.column_stack(desired)]
        axes.plot(*path, color=look(law).colour, ls=look(law).dash, lw=1.1)
    drawing.plot_reference(axes, *desired, dots)
    drawing.mark_start(axes, run["x"], run["y"])
    places = np.concatenate(seen)
    return places.min(axis=0), places.max(axis=0)


def paper_figure(number: int, group: Group) -> Iterator[drawing.Drawing]:
    """The panels of Fig. ``number``."""
    for panel in PANELS:
        if shown := panel.of(group):
            yield drawing.Drawing(
                f"fig{number}{panel.letter}_{panel.key}",
                PANEL_SIZE,
                partial(_draw_panel, panel=panel, group=shown),
                f"Fig. {number}({panel.letter}): {panel.title}",
            )


def _draw_panel(figure: Figure, panel: Panel, group: Group) -> None:
    if panel.column:
        (_draw_whole if panel.whole else _draw_parts)(figure, group, panel)
        more = drawing.switch_handles(next(iter(group.values())).settings)
    else:
        _draw_trajectory(figure, group)
        more = [marks.dot_handle("reference", "white", INK, size=3.2)]
    handles = [*marks.law_handles(group), *more]
    drawing.heading(figure, f"({panel.letter}) {panel.title}", handles)


def all_drawings(campaign: Campaign) -> tuple[drawing.Drawing, ...]:
    """Every figure of the report, in its order."""
    laws = campaign.table.laws
    fig3 = {law: campaign.runs["paper-simulation", law] for law in laws}
    fig5 = {law: campaign.runs["paper-experiment", law] for law in laws}
    return (
        *paper_figure(3, fig3),
        *paper_figure(5, fig5),
        *evidence_figures(campaign),
    )
