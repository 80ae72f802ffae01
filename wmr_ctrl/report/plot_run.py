"""One run on one page: path, velocities with limits, errors, and curves for its base and law.

A base that takes torques gets a curve of torques, one that takes velocities the filter's changes.
A law with a barrier gets V1, any other the distance from the desired position.
"""

import math
import os
from collections.abc import Mapping
from functools import partial
from textwrap import wrap
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import NullFormatter

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.results import (
    Floats,
    Run,
    distance,
    robots_over,
    tau_peak,
)
from wmr_ctrl.results.measures import heading_error
from wmr_ctrl.theory.checks.outlook import scenario_of_run

from . import course, drawing, style
from .run_rows import rows_of

Lines: TypeAlias = Mapping[str, tuple[Run, str, style.Dash]]
"""Run, colour and dashes by name."""
_SIZE = (8.3, 11.0)
_HEAD = 0.75
MARGINS = drawing.Padding(left=0.62, right=0.18, bottom=0.46, top=0.30)
SMALL = 0.1
"""Errors that come farther [m, rad] are drawn on a scale that is logarithmic beyond NARROW."""
NARROW = 0.01
LARGE = 10.0
"""Errors [m, rad] above which a plot uses m and rad; below it uses mm and mrad."""
LEAST = 1e-12
"""Values of V1 below it are drawn there."""
WIDTH = 64
"""Characters of a line of the run's figures."""
START = 2.0
"""Transient [s] that may leave the view."""
MEAN_TIME = 0.25
"""Torques and V1 are drawn as means over so long [s], with their samples faint behind."""
LEAST_DISTANCE = 0.01
"""Distances [mm] below it are drawn there."""
NEAR = 3.0
"""A torque limit is drawn if it is at most so many times the largest torque after the start."""


def plot_run(run: Run, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw an overview of ``run``, optionally into a .png, .svg or .pdf file; as `Run.plot`."""
    targets = drawing.picture_targets(path, "a run is drawn")
    return overview(run).written(targets)


def overview(run: Run) -> drawing.Drawing:
    """The page as a drawing; raises ArgumentError for a run without any sample."""
    if not run.rows:
        raise ArgumentError("the run has no sample to draw: it ended before the first one.")
    return drawing.Drawing("run", _SIZE, partial(_draw, run=run))


def _draw(figure: Figure, run: Run) -> None:
    title = f"{style.verbatim(run.scenario)}: {style.driver(run.law, run.guard)}"
    figure.text(0.02, 1 - 0.14 / _SIZE[1], title, size=13, weight="bold", va="top")
    planned, early = run.settings.duration, run.rows < run.settings.samples
    lasted = f"ended at {_ended(run):.4g} of {planned:g} s" if early else f"{planned:g} s"
    note = f"seed {run.seed}, {run.engine} engine, {lasted}"
    plants = {"mujoco": ", a rigid body on tyres", "fmu": ", somebody else's plant"}
    note += plants.get(run.settings.plant_kind, "")
    robots = robots_over(run.settings, 0.0, _ended(run))
    note += f"; {robots} (vertical lines)" if robots else ""
    tube = course.course_of_tube(run)
    note += "" if tube is None else "; errors, dotted: certified from a start on the path"
    figure.text(0.02, 1 - 0.42 / _SIZE[1], note, size=8.5, color=style.MUTED, va="top")
    rest = (_SIZE[1] - _HEAD) / 4.4
    heights = (_HEAD, 1.4 * rest, rest, rest, rest)
    grid = figure.add_gridspec(5, 2, height_ratios=heights, hspace=0.0, wspace=0.0)
    parts = [figure.add_subfigure(grid[row, column]) for row in range(1, 5) for column in (0, 1)]
    lines: Lines = {"": (run, style.look(run.law).colour, "-")}
    draw_paths(parts[0], lines, tube)
    _facts(parts[1], run)
    draw_velocity(parts[2], lines, 0)
    draw_velocity(parts[3], lines, 1)
    position = {"e₁": run["e[1]"], "e₂": run["e[2]"]}
    _errors(parts[4], run, "Position errors, Eq. (8)", position, tube)
    _errors(parts[5], run, "Orientation error e₃", {"e₃": heading_error(run)}, tube)
    (_filtered if "v_asked" in run else _torques)(parts[6], run)
    has_barrier = run.law in LAWS and LAWS[run.law].traits.barrier
    if has_barrier:
        _barrier(parts[7], run)
    else:
        draw_distance(parts[7], lines)


BAND = 800
"""Most points of a band."""


def draw_paths(part: SubFigure, lines: Lines, tube: Floats | None = None) -> None:
    """Paths on top of the desired one, with start, waypoints and goal; a single run's corridor."""
    axes = drawing.one_axes(part, MARGINS)
    longest = max((run for run, *_ in lines.values()), key=_ended)
    for run, colour, dash in lines.values():
        if tube is not None:  # as wide as the corridor is there, as long as there is one
            rows = np.unique(np.linspace(0, run.rows - 1, BAND).astype(int))
            edges = course.band(np.array([run["x_d"][rows], run["y_d"][rows]]), tube[0, rows])
            axes.fill(*edges, color=colour, alpha=course.FAINT, lw=0, zorder=1.4)
        opaque = 0.85 if len(lines) > 1 else 1.0
        way = run["x"], run["y"]
        axes.plot(*way, color=colour, ls=dash, lw=1.2, alpha=opaque)
        drawing.mark_start(axes, *way)
    drawing.plot_reference(axes, longest["x_d"], longest["y_d"])
    among = course.course_of(longest)
    marks = among.draw(axes)
    if all(among.draw_end(axes, run, colour) for run, colour, _ in lines.values()):
        marks.append("circle: end")
    drawing.finish_path(axes, ["dots: reference, ring: start", *marks])


def _facts(part: SubFigure, run: Run) -> None:
    """Outcome of the run as text and figures, and the keys of its remarks."""
    lines = [*wrap(run.explanation, WIDTH), ""]
    for name, text in rows_of(run):
        lines += wrap(f"{name}: {text}", WIDTH, subsequent_indent="    ")
    keys = dict.fromkeys(item.key for item in run.remarks if item.key != run.outcome.value)
    if keys:
        lines += ["", *wrap(f"Remarks, which `wmr-ctrl show` prints: {', '.join(keys)}.", WIDTH)]
    part.text(0.06, 0.93, "\n".join(lines), va="top", size=7.5, linespacing=1.4)


def draw_velocity(part: SubFigure, lines: Lines, axis: int) -> None:
    """Velocities with their limit, the desired one, and the command of a single run."""
    name, desired, unit = (("v1", "v1_d", "v₁ [m/s]"), ("omega", "v2_d", "ω [rad/s]"))[axis]
    runs, several = [run for run, *_ in lines.values()], len(lines) > 1
    longest = max(runs, key=_ended)
    sides, sent = longest.settings.sides[axis], ("v_command", "omega_command")[axis]
    commanded = sent in longest.columns and not several
    words = drawing.limits_in_words(*sides)
    text = f"{unit}, {words}; {'black, ' * several}dashed: desired"
    axes = _time_axes(part, text + ", thin: command" * commanded, *runs)
    if commanded:
        axes.step(longest.time, longest[sent], where="post", color=style.MUTED, lw=0.7, zorder=1.9)
    width, opaque = (0.9, 0.8) if several else (1.3, 0.6)
    for run, colour, dash in lines.values():
        axes.plot(run.time, run[name], color=colour, ls=dash, lw=width, alpha=opaque)
    axes.plot(longest.time, longest[desired], color=style.INK, ls=style.DASHED, lw=0.9, zorder=2.4)
    drawing.view_limits(axes, sides, {label: run[name] for label, (run, *_) in lines.items()})


def _errors(
    part: SubFigure, run: Run, title: str, errors: dict[str, Floats], tube: Floats | None
) -> None:
    """Errors over time, scaled such that both the start and the final error are visible.

    Dotted: the certified corridor of a robot that starts on its path.
    """
    farthest = max(float(np.nanmax(np.abs(row), initial=0.0)) for row in errors.values())
    unit, scale = "rad" if len(errors) == 1 else "m", 1.0
    if farthest < LARGE:
        unit, scale = f"m{unit}", 1e3
    rows = {label: scale * row for label, row in errors.items()}
    axes = _time_axes(part, f"{title} [{unit}]", run)
    _plot_pair(axes, run, rows)
    if tube is not None:
        most = scale * tube[1 if len(errors) == 1 else 0]
        for row in (-most, most):
            axes.plot(run.time, row, color=style.LIMIT, ls=style.DOTTED, lw=1.0, zorder=2.3)
    if farthest > SMALL:
        narrow = scale * NARROW
        axes.set_yscale("symlog", linthresh=narrow)
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "−"))
        axes.axhspan(-narrow, narrow, color=style.GRID, alpha=0.35, lw=0, zorder=0)
        drawing.say_below(axes, f"logarithmic beyond ±{narrow:g} {unit}")


def _plot_pair(axes: Axes, run: Run, rows: dict[str, Floats], alpha: float = 1.0) -> None:
    """One or two rows over time, the first in the law's colour and on top."""
    colours = (style.look(run.law).colour, style.MUTED)
    for (label, row), colour, zorder in zip(rows.items(), colours, (2.2, 2.1), strict=False):
        axes.plot(run.time, row, color=colour, lw=0.9, zorder=zorder, alpha=alpha,
                  label=label if alpha == 1 else None)  # fmt: skip
    if len(rows) > 1 and alpha == 1:
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, borderaxespad=0.1)


def _torques(part: SubFigure, run: Run) -> None:
    """Commanded torques: samples and their mean, with the drives' limit."""
    scenario = scenario_of_run(run)
    limit = scenario.actuator.tau_max if scenario else math.inf
    unit, scale = ("mN m", 1e3) if (tau_peak(run, START) or 1.0) < SMALL else ("N m", 1.0)
    limit *= scale
    rows = {"right": scale * run["tau_right"], "left": scale * run["tau_left"]}
    bound = "" if math.isinf(limit) else f", limit {limit:g}"
    axes = _time_axes(part, f"Wheel torques [{unit}]{bound}", run)
    width = max(1, round(MEAN_TIME / run.settings.control))
    _plot_pair(axes, run, rows, alpha=0.3)
    _plot_pair(axes, run, {name: drawing.running_mean(row, width) for name, row in rows.items()})
    if limit <= NEAR * scale * (tau_peak(run, START) or 0.0):
        drawing.include(axes, (-1.08 * limit, 1.08 * limit))
        drawing.shade_limits(axes, -limit, limit)
    else:
        _focus(axes, run, list(rows.values()), unit)


def _filtered(part: SubFigure, run: Run) -> None:
    """Changes by the filter: sent less requested command, relative to the limits."""
    sent = np.stack([run["v_command"], run["omega_command"]], axis=1)
    off = 100 * (sent - run["v_asked"]) / np.array(run.settings.v_u1)
    axes = _time_axes(part, "Changed by the filter [% of the limit]", run)
    _plot_pair(axes, run, {"v₁": off[:, 0], "ω": off[:, 1]})


def draw_distance(part: SubFigure, lines: Lines) -> None:
    """Distances from the desired position, on a logarithmic axis from `LEAST_DISTANCE` on."""
    title, runs = "Distance from the desired position [mm]", [run for run, *_ in lines.values()]
    axes = _time_axes(part, title, *runs)
    for run, colour, dash in lines.values():
        far = np.maximum(1e3 * distance(run), LEAST_DISTANCE)
        axes.plot(run.time, far, color=colour, ls=dash, lw=0.9)
    if axes.dataLim.ymin <= LEAST_DISTANCE:
        drawing.say_below(axes, f"axis starts at {LEAST_DISTANCE:g} mm")
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    low, high = axes.get_ylim()
    few = high < 10 * low  # no power of ten may be among the ticks then
    axes.yaxis.set_minor_formatter(axes.yaxis.get_major_formatter() if few else NullFormatter())


def _focus(axes: Axes, run: Run, columns: list[Floats], unit: str) -> None:
    """Zoom to the samples after the start, unless they already fill most of the view."""
    tail = np.concatenate([column[run.settings.index(START) :] for column in columns])
    if not tail.size or not np.isfinite(tail).all():
        return
    low, high = float(tail.min()), float(tail.max())
    margin = 0.6 * (high - low)
    bottom, top = axes.get_ylim()
    if margin and top - bottom > 6 * (high - low):
        axes.set_ylim(max(bottom, low - margin), min(top, high + margin))
        peak = max(float(np.abs(column).max()) for column in columns)
        drawing.say_below(axes, f"the start leaves the view: up to {style.shown(peak)} {unit}")


def _barrier(part: SubFigure, run: Run) -> None:
    axes = _time_axes(part, "Barrier function V₁ [1]", run)
    values, colour = np.maximum(run["V1"], LEAST), style.look(run.law).colour
    if values.min() <= LEAST:
        drawing.say_below(axes, f"axis starts at {LEAST:g}")
    axes.plot(run.time, values, color=colour, lw=0.8, alpha=0.3)
    width = max(1, round(MEAN_TIME / run.settings.control))
    axes.plot(run.time, drawing.running_mean(values, width), color=colour, lw=1.0)
    axes.set_yscale("log")


def _ended(run: Run) -> float:
    """End of a run's last sample [s]."""
    return float(run.time[-1]) + run.settings.control


def _time_axes(part: SubFigure, title: str, *runs: Run) -> Axes:
    """Axes over the longest run's time, with the changes of its robot."""
    longest = max(runs, key=_ended)
    axes, end = drawing.one_axes(part, MARGINS), _ended(longest)
    axes.set(xlabel="t [s]", xlim=(0, end))
    axes.set_title(title, weight="normal")
    drawing.mark_switch(axes, longest.settings, end)
    return axes
