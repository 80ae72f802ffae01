"""One run on one page: path, velocities with their limits, errors, torques, V1, and its figures."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from wmr_ctrl.errors import ArgumentError, ResultFileError
from wmr_ctrl.report.drawing import (
    Drawing,
    Padding,
    include,
    mark_switch,
    one_axes,
    save_figure,
    shade_limits,
    thin,
)
from wmr_ctrl.report.paper_figures import draw_paths, switch_time
from wmr_ctrl.report.style import DASHED, MUTED, driver, house_style, look, shown
from wmr_ctrl.results import FloatArray, Run, check_writable, e_rms, ise, tau_peak, tau_rms

SUFFIXES = (".png", ".svg", ".pdf")
_SIZE = (8.3, 11.0)
_HEAD = 0.75
_MARGINS = Padding(left=0.62, right=0.18, bottom=0.46, top=0.30)


def plot_run(run: Run, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw an overview of ``run``, into a .png, .svg or .pdf file too, whole or not at all.

    Raises ResultFileError for another suffix or where the file cannot be written, ArgumentError
    for a run without any sample.
    """
    target = None if path is None else _target(path)
    with house_style():
        figure = overview(run).figure()
        if target is not None:
            save_figure(figure, target)
    return figure


def _target(path: str | os.PathLike[str]) -> Path:
    """The path, which can be written and whose suffix names a format."""
    target = Path(path)
    if target.suffix.lower() not in SUFFIXES:
        raise ResultFileError(
            f"{str(target)!r} has the suffix {target.suffix!r}; a run is drawn as "
            f"{', '.join(SUFFIXES)}. Give the file one of these suffixes."
        )
    check_writable(target)
    return target


def overview(run: Run) -> Drawing:
    """The page as a drawing; raises ArgumentError for a run without any sample."""
    if not run.rows:
        raise ArgumentError("the run has no sample to draw: it ended before the first one.")
    return Drawing("run", f"{run.scenario}, {run.law}", "", _SIZE, partial(_draw, run=run))


def _draw(figure: Figure, run: Run) -> None:
    _header(figure, run)
    rest = (_SIZE[1] - _HEAD) / 4.4
    heights = (_HEAD, 1.4 * rest, rest, rest, rest)
    grid = figure.add_gridspec(5, 2, height_ratios=heights, hspace=0.0, wspace=0.0)
    parts = [figure.add_subfigure(grid[row, column]) for row in range(1, 5) for column in (0, 1)]
    _path(parts[0], run)
    _facts(parts[1], run)
    _velocity(parts[2], run, 0)
    _velocity(parts[3], run, 1)
    _lines(parts[4], run, "Position errors, Eq. (8) [m]", {"e₁": "e[1]", "e₂": "e[2]"})
    _lines(parts[5], run, "Orientation error e₃ [rad]", {"e₃": "e[3]"})
    _lines(parts[6], run, "Wheel torques [N m]", {"right": "tau_right", "left": "tau_left"})
    _barrier(parts[7], run)


def _header(figure: Figure, run: Run) -> None:
    figure.text(0.02, 1 - 0.14 / _SIZE[1], f"{run.scenario}: {driver(run.law, run.guard)}",
                size=13, weight="bold", va="top")  # fmt: skip
    note = f"seed {run.seed}, {run.engine} engine, {run.settings.duration:g} s"
    figure.text(0.02, 1 - 0.42 / _SIZE[1], note, size=8.5, color=MUTED, va="top")


def _path(part: SubFigure, run: Run) -> None:
    axes = one_axes(part, _MARGINS)
    draw_paths(axes, {run.law: run}, 3000)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_title("Path (dots: reference)", weight="normal")


def _facts(part: SubFigure, run: Run) -> None:
    """What the run came to, in words and figures."""
    lines = [*wrap(run.explanation, 58), "", *_figures(run)]
    part.text(0.06, 0.93, "\n".join(lines), va="top", size=8.2, linespacing=1.55)


def _figures(run: Run) -> list[str]:
    square = ise(run)
    (v1, omega), (limit_v, limit_w) = run.monitor.max_abs_v, run.settings.v_u1
    end = run.settings.duration
    errors = e_rms(run, max(0.0, end - 10.0), end) or (None, None, None)
    before, after = shown(square["before"]), shown(square["after"])
    parts = f" (before {run.settings.split:g} s {before}, after {after})"
    return [
        f"ISE {shown(square['total'])}{'' if switch_time(run) is None else parts}",
        f"largest |v₁| {shown(v1)} of {limit_v:g} m/s, |ω| {shown(omega)} of {limit_w:g} rad/s",
        f"plant steps beyond a limit: {run.monitor.violations}",
        f"wheel torque: peak {shown(tau_peak(run))} N m, RMS {shown(tau_rms(run))} N m",
        f"RMS errors of the last 10 s: {shown(errors[0])} m, {shown(errors[1])} m, "
        f"{shown(errors[2])} rad",
    ]


def _velocity(part: SubFigure, run: Run, axis: int) -> None:
    name, desired, unit = (("v1", "v1_d", "m/s"), ("omega", "v2_d", "rad/s"))[axis]
    symbol = ("v₁", "ω")[axis]
    axes = _time_axes(part, run, f"{symbol} [{unit}], its limits; dashed: desired")
    axes.plot(*thin(run.time, run[desired]), color=MUTED, ls=DASHED, lw=1.0)
    axes.plot(*thin(run.time, run[name]), color=look(run.law).colour, lw=1.0)
    limit = run.settings.v_u1[axis]
    include(axes, (-1.15 * limit, 1.15 * limit))
    shade_limits(axes, limit)


def _lines(part: SubFigure, run: Run, title: str, columns: dict[str, str]) -> None:
    """Scalar columns over time, the first in the law's colour; a focus on what follows the start.

    The view spans what the samples after the first 2 s need, unless the start needs little more.
    """
    axes = _time_axes(part, run, title)
    colours = (look(run.law).colour, MUTED)
    for (label, name), colour, zorder in zip(columns.items(), colours, (2.2, 2.1), strict=False):
        axes.plot(*thin(run.time, run[name]), color=colour, lw=0.9, label=label, zorder=zorder)
    if len(columns) > 1:
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, borderaxespad=0.1)
    _focus(axes, run, [run[name] for name in columns.values()])


def _focus(axes: Axes, run: Run, columns: list[FloatArray]) -> None:
    tail = np.concatenate([column[run.settings.index(2.0) :] for column in columns])
    if not tail.size or not np.isfinite(tail).all():
        return
    low, high = float(tail.min()), float(tail.max())
    margin = 0.6 * (high - low)
    bottom, top = axes.get_ylim()
    if margin and top - bottom > 6 * (high - low):
        axes.set_ylim(max(bottom, low - margin), min(top, high + margin))
        axes.annotate("the start leaves the view", (1, 1), xycoords="axes fraction", size=6.5,
                      xytext=(-2, -2), textcoords="offset points", va="top", ha="right",
                      color=MUTED)  # fmt: skip


def _barrier(part: SubFigure, run: Run) -> None:
    axes = _time_axes(part, run, "Barrier function V₁")
    values = np.maximum(run["V1"], 1e-12)
    axes.plot(*thin(run.time, values), color=look(run.law).colour, lw=0.8)
    axes.set_yscale("log")


def _time_axes(part: SubFigure, run: Run, title: str) -> Axes:
    axes = one_axes(part, _MARGINS)
    end = float(run.time[-1]) + run.settings.control
    axes.set(xlabel="t [s]", xlim=(0, end))
    axes.set_title(title, weight="normal")
    switch = switch_time(run)
    mark_switch(axes, switch if switch is not None and switch < end else None)
    return axes
