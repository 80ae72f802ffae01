"""Fig. 3 and Fig. 5 of the paper: the twelve panels."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from wmr_ctrl.results import Floats, Run, distance

from . import drawing
from .style import INK, MUTED, look

Group: TypeAlias = Mapping[str, Run]
"""Runs of one scenario by law, in the order in which they are drawn and named."""
Draw: TypeAlias = Callable[[drawing.Place, Group, drawing.Padding], None]
WIDTHS = (1.0, 1.75)
GAP = 0.42
START = 3.0
"""Length of the beginning that is shown enlarged [s]."""
PANEL_SIZE = (4.7, 2.9)


@dataclass(frozen=True)
class Panel:
    """One panel: its letter in the paper, a name for files, a title, and its drawing function.

    ``laws`` restricts it to laws that have the quantity (None: all); a ``path`` has the reference
    in its legend, all others the change of parameters.
    """

    letter: str
    key: str
    title: str
    draw: Draw
    laws: tuple[str, ...] | None = None
    path: bool = False

    def of(self, group: Group) -> Group:
        """The runs of ``group`` that this panel shows."""
        return {law: run for law, run in group.items() if self.laws is None or law in self.laws}


@dataclass(frozen=True)
class Trace:
    """A quantity over time and its presentation.

    ``value`` takes it from a run, shape (N,); ``early`` [s] is the length of the enlarged start;
    ``limit_axis`` (0 or 1) names the velocity limit to shade; ``smooth`` [s] draws a running mean
    of that length over the faint samples, on the right; ``late`` fixes the right axes' range.
    """

    label: str
    value: Callable[[Run], Floats]
    early: float = 2.0
    limit_axis: int | None = None
    smooth: float = 0.0
    late: tuple[float, float] | None = None

    def draw(self, place: drawing.Place, group: Group, padding: drawing.Padding) -> None:
        """Draw the quantity of every run."""
        start, rest = drawing.row_of_axes(place, padding, WIDTHS, GAP)
        for law, run in group.items():
            seen, cut, t, y = look(law), run.settings.index(self.early), run.time, self.value(run)
            start.plot(t[: cut + 1], y[: cut + 1], color=seen.colour, ls=seen.dash)
            t, y = t[cut:], y[cut:]
            if self.smooth:
                rest.plot(t, y, color=seen.colour, lw=0.5, alpha=0.25)
                mean = drawing.running_mean(y, max(1, round(self.smooth / run.settings.control)))
                rest.plot(t, mean, color=seen.colour, ls=seen.dash, lw=1.2, zorder=2.5)
            else:
                rest.plot(t, y, color=seen.colour, ls=seen.dash, lw=0.9)
        run = next(iter(group.values()))
        start.set(xlabel=f"t [s], first {self.early:g} s", xlim=(0, self.early), ylabel=self.label)
        mean_text = f" (line: {self.smooth:g} s mean)" if self.smooth else ""
        rest.set(xlabel=f"t [s], from {self.early:g} s on{mean_text}")
        rest.set_xlim(0, run.settings.duration)
        if self.late:
            rest.set_ylim(self.late)
        if self.limit_axis is not None:
            low, high = run.settings.sides[self.limit_axis]
            drawing.include(start, (1.1 * low, 1.1 * high))
            drawing.shade_limits(start, low, high)
            drawing.shade_limits(rest, low, high)
        drawing.mark_switch(rest, run.settings)


@dataclass(frozen=True)
class WholeTrace:
    """A quantity over the whole run on one scale.

    Linear from zero; or with a ``floor``, below which nothing is shown, logarithmic: faint samples
    under a running mean of length ``mean`` [s].
    """

    label: str
    value: Callable[[Run], Floats]
    floor: float = 0.0
    mean: float = 0.5

    def draw(self, place: drawing.Place, group: Group, padding: drawing.Padding) -> None:
        """Draw the quantity of every run."""
        axes = drawing.one_axes(place, padding)
        axes.set(xlabel="t [s]", ylabel=self.label)
        for law, run in group.items():
            seen, y = look(law), self.value(run)
            if self.floor:
                y = np.maximum(y, self.floor)
                axes.plot(run.time, y, color=seen.colour, lw=0.4, alpha=0.2)
                y = drawing.running_mean(y, max(1, round(self.mean / run.settings.control)))
                axes.set(xlabel=f"t [s] (faint: samples; line: {self.mean:g} s mean)", yscale="log")
            axes.plot(run.time, y, color=seen.colour, ls=seen.dash, zorder=2.5)
        run = next(iter(group.values()))
        axes.set(xlim=(0, run.settings.duration))
        axes.set_ylim(bottom=self.floor)
        drawing.mark_switch(axes, run.settings)


def draw_trajectory(place: drawing.Place, group: Group, padding: drawing.Padding) -> None:
    """Paths of all laws with their reference; on the right the first seconds; equal scales."""
    whole, start = drawing.row_of_axes(place, padding, (1.0, 1.0), 0.6)
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


def _column(name: str) -> Callable[[Run], Floats]:
    return lambda run: run[name]


def _error(name: str) -> Callable[[Run], Floats]:
    """True pose less reference, unlike the body-frame errors of Eq. (8)."""
    return lambda run: run[name] - run[f"{name}_d"]


_V1 = WholeTrace("V₁ [1]", _column("V1"), floor=1e-6)
_LINEAR = Trace("v₁ [m/s]", _column("v1"), limit_axis=0, smooth=0.5, late=(-0.05, 1.15))
_ANGULAR = Trace("ω [rad/s]", _column("omega"), limit_axis=1, smooth=0.5, late=(-1.75, 1.75))
_X = Trace("$x - x_d$ [m]", _error("x"), early=5.0)
_Y = Trace("$y - y_d$ [m]", _error("y"), early=5.0)
_THETA = Trace("$θ - θ_d$ [rad]", _error("theta"), early=5.0, smooth=1.0)
_D = WholeTrace("d [mm]", lambda run: 1e3 * distance(run), floor=0.5)
_RIGHT = Trace("τ₁, right [N m]", _column("tau_right"), early=2.0, smooth=1.0)
_LEFT = Trace("τ₂, left [N m]", _column("tau_left"), early=2.0, smooth=1.0)
_W1 = WholeTrace("‖W₁‖ [1]", _column("W_norm[1]"))
_W2 = WholeTrace("‖W₂‖ [1]", _column("W_norm[2]"))
PANELS = (
    Panel("a", "trajectory", "Trajectory", draw_trajectory, path=True),
    Panel("b", "lyapunov", "Lyapunov function values V₁", _V1.draw),
    Panel("c", "v1", "Linear velocity and its limit", _LINEAR.draw),
    Panel("d", "omega", "Angular velocity and its limits", _ANGULAR.draw),
    Panel("e", "x_error", "Error along X", _X.draw),
    Panel("f", "y_error", "Error along Y", _Y.draw),
    Panel("g", "theta_error", "Error of the orientation", _THETA.draw),
    Panel("h", "distance", "Distance from the desired position", _D.draw),
    Panel("i", "tau_right", "Torque of the right wheel", _RIGHT.draw),
    Panel("j", "tau_left", "Torque of the left wheel", _LEFT.draw),
    Panel("k", "weights_1", "Norm of the weights, linear axis", _W1.draw, laws=("nn",)),
    Panel("l", "weights_2", "Norm of the weights, angular axis", _W2.draw, laws=("nn",)),
)
"""Panels (a) to (l)."""


def paper_figure(number: int, group: Group) -> Iterator[drawing.Drawing]:
    """The panels of Fig. ``number``."""
    for panel in PANELS:
        if panel.of(group):
            yield drawing.Drawing(
                f"fig{number}{panel.letter}_{panel.key}",
                PANEL_SIZE,
                partial(_draw_panel, panel=panel, group=group),
                f"Fig. {number}({panel.letter}): {panel.title}",
            )


def _draw_panel(figure: Figure, panel: Panel, group: Group) -> None:
    visible = panel.of(group)
    panel.draw(figure, visible, drawing.Padding())
    handles = _handles(visible, path=panel.path)
    drawing.heading(figure, f"({panel.letter}) {panel.title}", handles)


def _handles(group: Group, *, path: bool) -> list[Line2D]:
    run = next(iter(group.values()))
    if path:
        more = [drawing.dot_handle("reference", "white", INK, size=3.2)]
    else:
        more = drawing.switch_handles(run.settings)
    return [*drawing.law_handles(group), *more]
