"""One run on one page: path, velocities with their limits, errors, torques, V1, and its figures."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import partial
from textwrap import wrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Circle as CirclePatch
from matplotlib.patches import Patch, Polygon
from matplotlib.ticker import FuncFormatter

from wmr_ctrl.corridor import Corridor, find_corridor
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.report import drawing
from wmr_ctrl.report.paper_figures import scenario_behind, switch_time
from wmr_ctrl.report.style import (
    DASHED,
    DOTTED,
    GRID,
    INK,
    LIMIT,
    MUTED,
    driver,
    house_style,
    look,
    shown,
    verbatim,
)
from wmr_ctrl.results import FloatArray, Run, e_rms, ise, tau_peak, tau_rms
from wmr_ctrl.results.obstacles import Shape
from wmr_ctrl.scenario import override
from wmr_ctrl.world.references import Waypoints

SUFFIXES = (".png", ".svg", ".pdf")
_SIZE = (8.3, 11.0)
_HEAD = 0.75
MARGINS = drawing.Padding(left=0.62, right=0.18, bottom=0.46, top=0.30)
MOST_WAYPOINTS = 60
"""More would hide the path that they are on."""
SMALL = 100.0
"""Errors that come farther [mm, mrad] are drawn on a scale that is logarithmic beyond NARROW."""
NARROW = 10.0
START = 2.0
"""Transient [s] that may leave the view."""
MEAN_TIME = 0.25
"""Torques and V1 are drawn as means over so long [s], with their samples faint behind."""
NEAR = 3.0
"""A torque limit is drawn if it is at most so many times the largest torque after the start."""


def plot_run(run: Run, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw an overview of ``run``, into a .png, .svg or .pdf file too, whole or not at all.

    Raises ResultFileError for another suffix or where the file cannot be written, ArgumentError
    for a run without any sample.
    """
    known = f"a run is drawn as {', '.join(SUFFIXES)}"
    target = None if path is None else drawing.target_of(path, SUFFIXES, known)
    with house_style():
        if not run.rows:
            raise ArgumentError("the run has no sample to draw: it ended before the first one.")
        figure = drawing.Drawing("run", _SIZE, partial(_draw, run=run)).figure()
        if target is not None:
            drawing.save_figure(figure, target)
    return figure


def _draw(figure: Figure, run: Run) -> None:
    title = f"{verbatim(run.scenario)}: {driver(run.law, run.guard)}"
    figure.text(0.02, 1 - 0.14 / _SIZE[1], title, size=13, weight="bold", va="top")
    note = f"seed {run.seed}, {run.engine} engine, {run.settings.duration:g} s"
    figure.text(0.02, 1 - 0.42 / _SIZE[1], note, size=8.5, color=MUTED, va="top")
    rest = (_SIZE[1] - _HEAD) / 4.4
    heights = (_HEAD, 1.4 * rest, rest, rest, rest)
    grid = figure.add_gridspec(5, 2, height_ratios=heights, hspace=0.0, wspace=0.0)
    parts = [figure.add_subfigure(grid[row, column]) for row in range(1, 5) for column in (0, 1)]
    tube = _tube(run)
    _path(parts[0], run, tube)
    _facts(parts[1], run)
    _velocity(parts[2], run, 0)
    _velocity(parts[3], run, 1)
    _errors(parts[4], run, "Position errors, Eq. (8) [mm]", {"e₁": "e[1]", "e₂": "e[2]"}, tube)
    _errors(parts[5], run, "Orientation error e₃ [mrad]", {"e₃": "e[3]"}, tube)
    _torques(parts[6], run)
    _barrier(parts[7], run)


def _path(part: SubFigure, run: Run, tube: Corridor | None) -> None:
    """The robot's path on top of the desired one, with start, waypoints and goal."""
    axes = drawing.one_axes(part, MARGINS)
    if tube is not None:
        _draw_tube(axes, run, tube)
    drawing.plot_reference(axes, *drawing.thin_path(run["x_d"], run["y_d"], 64))
    axes.plot(*drawing.thin_path(run["x"], run["y"], 3000), color=look(run.law).colour, lw=1.2)
    axes.plot(run["x"][0], run["y"][0], "o", mfc="white", mec=INK, ms=4.5, zorder=4)
    marks = ["dots: reference"]
    scenario = scenario_behind(run)
    if scenario and isinstance(scenario.reference, Waypoints):
        points = np.array(scenario.reference.points)
        if len(points) <= MOST_WAYPOINTS:
            axes.plot(*points.T, "s", mfc="none", mec=INK, ms=6, mew=0.8, zorder=3.6)
            marks.append("squares: waypoints")
    for shape in scenario.reference.keep_out if scenario else ():
        axes.add_patch(_obstacle(shape))
    if run.settings.arrival is not None and run.settings.arrival <= run.time[-1]:
        axes.plot(run["x_d"][-1], run["y_d"][-1], "*", mfc=LIMIT, mec="white", ms=11, zorder=4)
        marks.append("star: goal")
    drawing.finish_path(axes, marks)


def _tube(run: Run) -> Corridor | None:
    """The certified corridor of the run's scenario and law, where there is one."""
    scenario = scenario_behind(run)
    if scenario is None or run.monitor.rigid or run.law not in LAWS:
        return None
    guarded = override(scenario, {"guard.enabled": run.guard})
    tube = find_corridor(guarded, run.law)
    return tube if tube.position is not None else None


def _draw_tube(axes: Axes, run: Run, tube: Corridor) -> None:
    """Band about the desired path, as wide as the corridor, until the robot changes."""
    rows = slice(0, None if tube.until is None else run.settings.index(tube.until))
    path = np.array(drawing.thin_path(run["x_d"][rows], run["y_d"][rows], 400))
    ahead = np.gradient(path, axis=1)
    side = (tube.position or 0.0) * np.array((-ahead[1], ahead[0])) / np.hypot(*ahead)
    edges = np.hstack([path + side, (path - side)[:, ::-1]])
    axes.fill(*edges, color=look(run.law).colour, alpha=0.25, lw=0, zorder=1.4)


def _obstacle(shape: Shape) -> Patch:
    """A polygon or circle that is kept out, hatched."""
    if isinstance(shape[0], tuple):
        patch: Patch = Polygon(np.array(shape))
    else:
        patch = CirclePatch((shape[0], shape[1]), shape[2])
    patch.set(facecolor=GRID, edgecolor=MUTED, hatch="////", linewidth=0.8, zorder=1.5)
    return patch


def _facts(part: SubFigure, run: Run) -> None:
    """Outcome of the run, in words and figures."""
    lines = [*wrap(run.explanation, 58), "", *_figures(run)]
    part.text(0.06, 0.93, "\n".join(lines), va="top", size=8.2, linespacing=1.55)


def _figures(run: Run) -> list[str]:
    square = ise(run)
    (v1, omega), (limit_v, limit_w) = run.monitor.max_abs_v, run.settings.v_u1
    arrival, end = run.settings.arrival, run.settings.duration
    end, of = (end, "") if arrival is None or arrival > end else (arrival, " of the drive")
    errors = e_rms(run, max(0.0, end - 10.0), end) or (None, None, None)
    small = [None if error is None else 1e3 * error for error in errors]
    before, after = shown(square["before"]), shown(square["after"])
    parts = f" (before {run.settings.split:g} s {before}, after {after})"
    return [
        f"ISE {shown(square['total'])} m² s + rad² s{'' if switch_time(run) is None else parts}",
        f"largest |v₁| {shown(v1)} of {limit_v:g} m/s, |ω| {shown(omega)} of {limit_w:g} rad/s",
        f"plant steps beyond a limit: {run.monitor.violations}",
        f"wheel torque: peak {shown(tau_peak(run))} N m, RMS {shown(tau_rms(run))} N m",
        f"RMS errors of the last 10 s{of}:",
        f"    e₁ {shown(small[0])} mm, e₂ {shown(small[1])} mm, e₃ {shown(small[2])} mrad",
    ]


def _velocity(part: SubFigure, run: Run, axis: int) -> None:
    name, desired, unit = (("v1", "v1_d", "m/s"), ("omega", "v2_d", "rad/s"))[axis]
    symbol = ("v₁", "ω")[axis]
    axes = _time_axes(part, run, f"{symbol} [{unit}], its limits; dashed: desired")
    axes.plot(*drawing.thin(run.time, run[name]), color=look(run.law).colour, lw=1.3, alpha=0.6)
    axes.plot(*drawing.thin(run.time, run[desired]), color=INK, ls=DASHED, lw=0.9, zorder=2.4)
    limit = run.settings.v_u1[axis]
    drawing.include(axes, (-1.15 * limit, 1.15 * limit))
    drawing.shade_limits(axes, limit)


def _errors(
    part: SubFigure, run: Run, title: str, columns: dict[str, str], tube: Corridor | None
) -> None:
    """Errors over time, in mm or mrad, so that the start and what is left at the end are seen.

    Dotted: the certified corridor, which is that of a robot on its path.
    """
    rows = {label: 1e3 * run[name] for label, name in columns.items()}
    axes = _time_axes(part, run, title)
    _plot_pair(axes, run, rows)
    if tube is not None:
        most = 1e3 * float((tube.heading if len(columns) == 1 else tube.position) or 0.0)
        end = run.time[-1] if tube.until is None else min(tube.until, run.time[-1])
        axes.hlines((-most, most), 0, end, color=LIMIT, ls=DOTTED, lw=1.0, zorder=2.3)
        axes.annotate("certified from a start on the path", (end, most), size=6.5, xytext=(-2, 2),
                      textcoords="offset points", ha="right", color=LIMIT)  # fmt: skip
    if max(float(np.nanmax(np.abs(row), initial=0.0)) for row in rows.values()) > SMALL:
        axes.set_yscale("symlog", linthresh=NARROW)
        axes.yaxis.set_major_formatter(
            FuncFormatter(lambda value, _: f"{value:g}".replace("-", "−"))
        )
        axes.axhspan(-NARROW, NARROW, color=GRID, alpha=0.35, lw=0, zorder=0)
        note = f"logarithmic beyond ±{NARROW:g}"
        axes.annotate(note, (1, 0), xycoords="axes fraction", size=6.5, xytext=(-2, 2),
                      textcoords="offset points", ha="right", color=MUTED)  # fmt: skip


def _plot_pair(axes: Axes, run: Run, rows: dict[str, FloatArray], alpha: float = 1.0) -> None:
    """One or two rows over time, the first in the law's colour and on top."""
    colours = (look(run.law).colour, MUTED)
    for (label, row), colour, zorder in zip(rows.items(), colours, (2.2, 2.1), strict=False):
        axes.plot(*drawing.thin(run.time, row), color=colour, lw=0.9, zorder=zorder, alpha=alpha,
                  label=label if alpha == 1 else None)  # fmt: skip
    if len(rows) > 1 and alpha == 1:
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, borderaxespad=0.1)


def _torques(part: SubFigure, run: Run) -> None:
    """Commanded torques: samples and their mean, with the drives' limit."""
    rows = {"right": run["tau_right"], "left": run["tau_left"]}
    scenario = scenario_behind(run)
    limit = scenario.actuator.tau_max if scenario else math.inf
    bound = "" if math.isinf(limit) else f", limit {limit:g}"
    axes = _time_axes(part, run, f"Wheel torques [N m]{bound}")
    width = max(1, round(MEAN_TIME / run.settings.control))
    _plot_pair(axes, run, rows, alpha=0.3)
    _plot_pair(axes, run, {name: drawing.running_mean(row, width) for name, row in rows.items()})
    if limit <= NEAR * (tau_peak(run, START) or 0.0):
        drawing.include(axes, (-1.08 * limit, 1.08 * limit))
        drawing.shade_limits(axes, limit)
    else:
        _focus(axes, run, list(rows.values()))


def _focus(axes: Axes, run: Run, columns: list[FloatArray]) -> None:
    """Zoom to the samples after the start, unless they fill most of the view."""
    tail = np.concatenate([column[run.settings.index(START) :] for column in columns])
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
    axes = _time_axes(part, run, "Barrier function V₁ [1]")
    values, colour = np.maximum(run["V1"], 1e-12), look(run.law).colour
    axes.plot(*drawing.thin(run.time, values), color=colour, lw=0.8, alpha=0.3)
    width = max(1, round(MEAN_TIME / run.settings.control))
    axes.plot(*drawing.thin(run.time, drawing.running_mean(values, width)), color=colour, lw=1.0)
    axes.set_yscale("log")


def time_axes(part: SubFigure, runs: Sequence[Run], title: str) -> Axes:
    """Axes over the time of the longest of the runs."""
    axes = drawing.one_axes(part, MARGINS)
    end = max(float(run.time[-1]) + run.settings.control for run in runs)
    axes.set(xlabel="t [s]", xlim=(0, end))
    axes.set_title(title, weight="normal")
    return axes


def _time_axes(part: SubFigure, run: Run, title: str) -> Axes:
    axes, switch = time_axes(part, [run], title), switch_time(run)
    drawing.mark_switch(
        axes, switch if switch is not None and switch < axes.get_xlim()[1] else None
    )
    return axes
