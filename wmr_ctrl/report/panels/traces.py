"""Panels over time: the first seconds enlarged on the left, the rest on the right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.axes import Axes

from wmr_ctrl.report.canvas import (
    Margins,
    Place,
    include,
    mark_switch,
    row_of_axes,
    shade_limits,
)
from wmr_ctrl.report.decimate import running_mean, thin
from wmr_ctrl.report.panels.base import Group, switch_time
from wmr_ctrl.report.style import look
from wmr_ctrl.results import FloatArray, Run

WIDTHS = (1.0, 1.75)
GAP = 0.42


@dataclass(frozen=True, slots=True)
class Trace:
    """A quantity over time and how it is shown.

    ``value`` takes it from a run, shape (N,); ``early`` [s] is the length of the enlarged start;
    ``limit_axis`` (0 or 1) names the velocity limit to shade; ``smooth`` [s] draws a running mean
    of that length over the faint samples, on the right; ``late`` fixes the right axes' range.
    """

    label: str
    value: Callable[[Run], FloatArray]
    early: float = 2.0
    limit_axis: int | None = None
    smooth: float = 0.0
    late: tuple[float, float] | None = None

    def draw(self, place: Place, group: Group, margins: Margins) -> None:
        """Draw the quantity of every run."""
        start, rest = row_of_axes(place, margins, WIDTHS, GAP)
        for law, run in group.items():
            self._plot_start(start, law, run)
            self._plot_rest(rest, law, run)
        self._finish(start, rest, group)

    def _plot_start(self, axes: Axes, law: str, run: Run) -> None:
        rows = slice(0, run.settings.index(self.early) + 1)
        seen = look(law)
        axes.plot(run.time[rows], self.value(run)[rows], color=seen.colour, ls=seen.dash)

    def _plot_rest(self, axes: Axes, law: str, run: Run) -> None:
        rows, seen = slice(run.settings.index(self.early), None), look(law)
        t, y = run.time[rows], self.value(run)[rows]
        if not self.smooth:
            axes.plot(*thin(t, y), color=seen.colour, ls=seen.dash, lw=0.9)
            return
        axes.plot(*thin(t, y), color=seen.colour, lw=0.5, alpha=0.25)
        mean = running_mean(y, max(1, round(self.smooth / run.settings.control)))
        axes.plot(*thin(t, mean, 500), color=seen.colour, ls=seen.dash, lw=1.2, zorder=2.5)

    def _finish(self, start: Axes, rest: Axes, group: Group) -> None:
        run = next(iter(group.values()))
        start.set(xlabel=f"t [s], first {self.early:g} s", xlim=(0, self.early), ylabel=self.label)
        rest.set(xlabel=self._rest_label(), xlim=(0, run.settings.duration))
        if self.late:
            rest.set_ylim(self.late)
        if self.limit_axis is not None:
            limit = run.settings.v_u1[self.limit_axis]
            include(start, (-1.1 * limit, 1.1 * limit))
            shade_limits(start, limit)
            shade_limits(rest, limit)
        mark_switch(rest, switch_time(run))

    def _rest_label(self) -> str:
        after = f"t [s], from {self.early:g} s on"
        return f"{after} (line: {self.smooth:g} s mean)" if self.smooth else after
