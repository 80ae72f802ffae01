"""Several runs in one picture: paths, distance from the reference, both velocities."""

import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import FuncFormatter, NullFormatter

from wmr_ctrl.report.course import course_of, switch_time
from wmr_ctrl.report.drawing import (
    Drawing,
    finish_path,
    heading,
    line_handle,
    mark_switch,
    one_axes,
    plot_reference,
    save_figure,
    say_below,
    switch_handles,
    target_of,
    thin,
    thin_path,
    view_limits,
)
from wmr_ctrl.report.plot_run import MARGINS, SUFFIXES, time_axes
from wmr_ctrl.report.scene import names_of, scene_of
from wmr_ctrl.report.style import DASHED, DASHES, INK, Dash, colours_of, house_style, verbatim
from wmr_ctrl.results import Run, distance

Lines: TypeAlias = Mapping[str, tuple[Run, str, Dash]]
"""Run, colour and dashes by name."""
_SIZE = (8.3, 7.0)
_HEAD = 0.55
_LEAST = 0.01
"""Distances below it are drawn there [mm]."""


def plot_runs(runs: Sequence[Run], path: str | os.PathLike[str]) -> None:
    """Draw runs over each other into a .png, .svg or .pdf file, whole or not at all.

    Raises ResultFileError for another suffix or where the file cannot be written, ArgumentError
    for runs that one picture cannot show (`scene_of`).
    """
    target = target_of(path, SUFFIXES, f"runs are drawn as {', '.join(SUFFIXES)}")
    scene_of(runs, 1)
    with house_style():
        save_figure(Drawing("runs", _SIZE, partial(_draw, runs=runs)).figure(), target)


def _draw(figure: Figure, runs: Sequence[Run]) -> None:
    grid = figure.add_gridspec(3, 2, height_ratios=(_HEAD, 3.5, 2.95), hspace=0.0, wspace=0.0)
    top = figure.add_subfigure(grid[0, :])
    colours = colours_of([run.law for run in runs])
    lines = {
        name: (run, colour, DASHES[place % len(DASHES)])
        for place, (name, run, colour) in enumerate(zip(names_of(runs), runs, colours, strict=True))
    }
    handles = [line_handle(name, colour, dash=dash) for name, (_, colour, dash) in lines.items()]
    handles += switch_handles(switch_time(runs[0]))
    heading(top, verbatim(runs[0].scenario), handles)
    parts = [figure.add_subfigure(grid[row, column]) for row in (1, 2) for column in (0, 1)]
    _path(parts[0], lines)
    _distance(parts[1], lines)
    _velocity(parts[2], lines, 0)
    _velocity(parts[3], lines, 1)


def _longest(lines: Lines) -> Run:
    return max((run for run, *_ in lines.values()), key=lambda run: run.rows * run.settings.control)


def _path(part: SubFigure, lines: Lines) -> None:
    axes, longest = one_axes(part, MARGINS), _longest(lines)
    for run, colour, dash in lines.values():
        x, y = thin_path(run["x"], run["y"], 3000)
        axes.plot(x, y, color=colour, ls=dash, lw=1.2, alpha=0.85)
        axes.plot(x[0], y[0], "o", mfc="white", mec=INK, ms=4.5, zorder=4)
    plot_reference(axes, *thin_path(longest["x_d"], longest["y_d"], 64))
    finish_path(axes, ["dots: reference, ring: start", *course_of(longest).draw(axes)])


def _over_time(part: SubFigure, lines: Lines, title: str) -> Axes:
    axes = time_axes(part, [run for run, *_ in lines.values()], title)
    switch = switch_time(_longest(lines))
    mark_switch(axes, switch if switch is not None and switch < axes.get_xlim()[1] else None)
    return axes


def _distance(part: SubFigure, lines: Lines) -> None:
    axes = _over_time(part, lines, "Distance from the desired position [mm]")
    for run, colour, dash in lines.values():
        far = np.maximum(1e3 * distance(run), _LEAST)
        axes.plot(*thin(run.time, far), color=colour, ls=dash, lw=0.9)
    if axes.dataLim.ymin <= _LEAST:
        say_below(axes, f"less is drawn at {_LEAST:g} mm")
    axes.set_yscale("log")
    plain = FuncFormatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_major_formatter(plain)
    low, high = axes.get_ylim()
    few = high < 10 * low  # no power of ten may be among the ticks then
    axes.yaxis.set_minor_formatter(plain if few else NullFormatter())


def _velocity(part: SubFigure, lines: Lines, axis: int) -> None:
    name, desired, text = (("v1", "v1_d", "v₁ [m/s]"), ("omega", "v2_d", "ω [rad/s]"))[axis]
    longest = _longest(lines)
    limit = longest.settings.v_u1[axis]
    axes = _over_time(part, lines, f"{text}, limit ±{limit:g}; black, dashed: desired")
    for run, colour, dash in lines.values():
        axes.plot(*thin(run.time, run[name]), color=colour, ls=dash, lw=0.9, alpha=0.8)
    axes.plot(*thin(longest.time, longest[desired]), color=INK, ls=DASHED, lw=0.9, zorder=2.4)
    view_limits(axes, limit, {label: run[name] for label, (run, *_) in lines.items()})
