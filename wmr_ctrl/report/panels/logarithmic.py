"""Panels over time on a logarithmic scale: V1 and the distance; and the weights' norms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.report.canvas import Margins, Place, mark_switch, one_axes
from wmr_ctrl.report.decimate import running_mean, thin
from wmr_ctrl.report.panels.base import Group, switch_time
from wmr_ctrl.report.style import look
from wmr_ctrl.results import FloatArray, Run


@dataclass(frozen=True, slots=True)
class Logarithmic:
    """A positive quantity over the whole run: faint samples under a running mean.

    ``mean`` is the length of that mean [s]; what lies under ``floor`` is not shown.
    """

    label: str
    value: Callable[[Run], FloatArray]
    floor: float
    mean: float = 0.5

    def draw(self, place: Place, group: Group, margins: Margins) -> None:
        """Draw the quantity of every run."""
        axes = one_axes(place, margins)
        for law, run in group.items():
            seen, y = look(law), np.maximum(self.value(run), self.floor)
            axes.plot(*thin(run.time, y, 1000), color=seen.colour, lw=0.4, alpha=0.2)
            mean = running_mean(y, max(1, round(self.mean / run.settings.control)))
            axes.plot(*thin(run.time, mean, 600), color=seen.colour, ls=seen.dash, zorder=2.5)
        run = next(iter(group.values()))
        axes.set(ylabel=self.label, yscale="log", xlim=(0, run.settings.duration))
        axes.set_xlabel(f"t [s] (faint: samples; line: {self.mean:g} s mean)")
        axes.set_ylim(bottom=self.floor)
        mark_switch(axes, switch_time(run))


@dataclass(frozen=True, slots=True)
class Plain:
    """A quantity over the whole run on a linear scale from zero."""

    label: str
    value: Callable[[Run], FloatArray]

    def draw(self, place: Place, group: Group, margins: Margins) -> None:
        """Draw the quantity of every run."""
        axes = one_axes(place, margins)
        for law, run in group.items():
            seen = look(law)
            axes.plot(*thin(run.time, self.value(run)), color=seen.colour, ls=seen.dash)
        run = next(iter(group.values()))
        axes.set(xlabel="t [s]", ylabel=self.label, xlim=(0, run.settings.duration))
        axes.set_ylim(bottom=0)
        mark_switch(axes, switch_time(run))
