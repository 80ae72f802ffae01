"""Several runs in one picture: paths, distance from the reference, both velocities."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import FuncFormatter, NullFormatter

from wmr_ctrl.report.drawing import (
    Drawing,
    finish_path,
    heading,
    include,
    line_handle,
    one_axes,
    plot_reference,
    save_figure,
    shade_limits,
    target_of,
    thin,
    thin_path,
)
from wmr_ctrl.report.plot_run import MARGINS, SUFFIXES, time_axes
from wmr_ctrl.report.scene import names_of, scene_of
from wmr_ctrl.report.style import DASHED, INK, colours_of, house_style, verbatim
from wmr_ctrl.results import Run, distance

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
    handles = [line_handle(*pair) for pair in zip(names_of(runs), colours, strict=True)]
    heading(top, verbatim(runs[0].scenario), handles)
    parts = [figure.add_subfigure(grid[row, column]) for row in (1, 2) for column in (0, 1)]
    _path(parts[0], runs, colours)
    _distance(parts[1], runs, colours)
    _velocity(parts[2], runs, colours, 0)
    _velocity(parts[3], runs, colours, 1)


def _path(part: SubFigure, runs: Sequence[Run], colours: Sequence[str]) -> None:
    axes = one_axes(part, MARGINS)
    longest = max(runs, key=lambda run: run.rows * run.settings.control)
    for run, colour in zip(runs, colours, strict=True):
        axes.plot(*thin_path(run["x"], run["y"], 3000), color=colour, lw=1.2, alpha=0.85)
    plot_reference(axes, *thin_path(longest["x_d"], longest["y_d"], 64))
    finish_path(axes, ["dots: reference"])


def _distance(part: SubFigure, runs: Sequence[Run], colours: Sequence[str]) -> None:
    axes = time_axes(part, runs, "Distance from the desired position [mm]")
    for run, colour in zip(runs, colours, strict=True):
        axes.plot(*thin(run.time, np.maximum(1e3 * distance(run), _LEAST)), color=colour, lw=0.9)
    axes.set_yscale("log")
    plain = FuncFormatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_major_formatter(plain)
    low, high = axes.get_ylim()
    few = high < 10 * low  # no power of ten may be among the ticks then
    axes.yaxis.set_minor_formatter(plain if few else NullFormatter())


def _velocity(part: SubFigure, runs: Sequence[Run], colours: Sequence[str], axis: int) -> None:
    name, desired, text = (("v1", "v1_d", "v₁ [m/s]"), ("omega", "v2_d", "ω [rad/s]"))[axis]
    axes = time_axes(part, runs, f"{text}, its limits; dashed: desired")
    for run, colour in zip(runs, colours, strict=True):
        axes.plot(*thin(run.time, run[name]), color=colour, lw=0.9, alpha=0.8)
    longest = max(runs, key=lambda run: run.rows * run.settings.control)
    axes.plot(*thin(longest.time, longest[desired]), color=INK, ls=DASHED, lw=0.9, zorder=2.4)
    limit = runs[0].settings.v_u1[axis]
    include(axes, (-1.15 * limit, 1.15 * limit))
    shade_limits(axes, limit)
