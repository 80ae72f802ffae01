"""Several runs, or drives, in one picture.

For runs: paths, distance from the reference, both velocities.  For drives: the path, and all other
data of their bags, over time.
"""

from collections.abc import Callable, Sequence
from functools import partial
from math import ceil
from textwrap import fill
from typing import TypeAlias

import numpy as np
from matplotlib.figure import Figure, SubFigure

from wmr_ctrl.core.fields.files import AnyPath
from wmr_ctrl.results import Floats, Run
from wmr_ctrl.results.drive import (
    COMMANDS,
    NEVER,
    POSES,
    SPEEDS,
    TORQUES,
    WHEEL_ANGLE,
    WHEEL_SPEEDS,
    RecordedDrive,
)

from . import drawing
from .plot_run import MARGINS, draw_distance, draw_paths, draw_velocity
from .scene import names_of, scene_of
from .style import DASHED, DASHES, DOTTED, INK, MUTED, colours_of, verbatim

_SIZE = (8.3, 7.0)
_HEAD = 0.55


def plot_runs(runs: Sequence[Run], path: AnyPath) -> None:
    """Draw runs over each other into a .png, .svg or .pdf file; as `Run.plot` and `scene_of`."""
    targets = drawing.picture_targets(path, "runs are drawn")
    scene_of(runs, 1)
    drawing.Drawing("runs", _SIZE, partial(_draw, runs=runs)).written(targets)


def _draw(figure: Figure, runs: Sequence[Run]) -> None:
    grid = figure.add_gridspec(3, 2, height_ratios=(_HEAD, 3.5, 2.95), hspace=0.0, wspace=0.0)
    top = figure.add_subfigure(grid[0, :])
    looks = zip(names_of(runs), runs, colours_of([run.law for run in runs]), strict=True)
    lines = {
        name: (run, colour, DASHES[place % len(DASHES)])
        for place, (name, run, colour) in enumerate(looks)
    }
    styles = ((name, colour, dash) for name, (_, colour, dash) in lines.items())
    handles = [drawing.line_handle(name, colour, dash=dash) for name, colour, dash in styles]
    handles += drawing.switch_handles(runs[0].settings)
    drawing.heading(top, verbatim(runs[0].scenario), handles)
    parts = [figure.add_subfigure(grid[row, column]) for row in (1, 2) for column in (0, 1)]
    draw_paths(parts[0], lines)
    draw_distance(parts[1], lines)
    draw_velocity(parts[2], lines, 0)
    draw_velocity(parts[3], lines, 1)


_WIDTH, _TITLE, _HIGH, _PATH = 8.3, 0.72, 1.9, 2.9
"""Width of the page; heights of its head, of a row, and of the row with the path [inch]."""
LEFT_OUT = f"A bag has no {NEVER.replace('V1', 'V₁')}."
PANELS: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...] = (
    ("v₁ [m/s]", SPEEDS[:1], COMMANDS[:1]),
    ("ω [rad/s]", SPEEDS[1:], COMMANDS[1:]),
    ("Wheel torques [N m]; right, dotted: left", TORQUES, ()),
    ("Wheel speeds [rad/s]; right, dotted: left", WHEEL_SPEEDS, ()),
    ("Wheel angles [rad]; right, dotted: left", WHEEL_ANGLE, ()),
)
"""Title, columns and commands of each picture over time; one that no drive has is left out."""
NOTHING: Floats = np.zeros(0)
Drives: TypeAlias = Sequence[tuple[RecordedDrive, str]]
"""Drives with their colours."""
Panel: TypeAlias = Callable[[SubFigure], None]


def plot_drives(drives: Sequence[RecordedDrive], path: AnyPath | None = None) -> Figure:
    """Draw drives over each other, optionally into a .png, .svg or .pdf file; as
    `RecordedDrive.plot`.

    Quantities that no drive has are left out, and named.
    """
    targets = drawing.picture_targets(path, "drives are drawn")
    return page_of(drives).written(targets)


def page_of(drives: Sequence[RecordedDrive]) -> drawing.Drawing:
    """The page as a drawing."""
    lines = [*zip(drives, colours_of([drive.name for drive in drives]), strict=True)]
    panels: list[Panel] = []
    if any(drive.has(POSES) for drive in drives):
        panels.append(partial(_drive_paths, lines))
    for title, measured, commands in PANELS:
        there = {k for k in (*measured, *commands) if any(drive.has([k]) for drive in drives)}
        if there:
            title += "; dashed: as commanded" * bool(there & {*commands})
            panels.append(partial(_panel, lines, title, measured, commands))
    head = _TITLE if len(drives) > 1 else _TITLE - 0.2
    heights = (head, _PATH, *[_HIGH] * (ceil(len(panels) / 2) - 1))
    draw = partial(_draw_page, lines, panels, heights)
    return drawing.Drawing("drive", (_WIDTH, sum(heights)), draw)


def _draw_page(
    lines: Drives, panels: Sequence[Panel], heights: Sequence[float], figure: Figure
) -> None:
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights, hspace=0.0, wspace=0.0)
    top = figure.add_subfigure(grid[0, :])
    handles = [drawing.line_handle(verbatim(drive.name), colour) for drive, colour in lines]
    several, first = len(lines) > 1, lines[0][0]
    title = "Drives" if several else verbatim(first.name)
    drawing.heading(top, title, handles if several else ())
    nowhere = [name for name in first.missing if all(name in one.missing for one, _ in lines)]
    lacking = f" Nor is there {', '.join(nowhere)}." if nowhere else ""
    note = fill(LEFT_OUT + lacking, 150)
    top.text(0.06 / _WIDTH, 0.02, note, size=7.0, color=MUTED, va="bottom")
    for place, panel in enumerate(panels):
        panel(figure.add_subfigure(grid[1 + place // 2, place % 2]))


def _drive_paths(lines: Drives, part: SubFigure) -> None:
    """Paths from odometry, each with its start."""
    axes = drawing.one_axes(part, MARGINS)
    for drive, colour in lines:
        if drive.has(POSES):
            x, y = (drive.columns[name] for name in POSES[:2])
            axes.plot(x, y, color=colour, lw=1.2, alpha=0.85)
            drawing.mark_start(axes, x, y)
    drawing.finish_path(axes, ["ring: start"])


def _panel(
    lines: Drives, title: str, measured: Sequence[str], commands: Sequence[str], part: SubFigure
) -> None:
    axes = drawing.one_axes(part, MARGINS)
    axes.set(xlabel="t [s]", xlim=(0, max(drive.duration for drive, _ in lines)))
    axes.set_title(title, weight="normal")
    for drive, colour in lines:
        for name, dash in zip(measured, ("-", DOTTED), strict=False):
            axes.plot(*_trace(drive, name), color=colour, ls=dash, lw=0.9, alpha=0.8)
        said = INK if len(lines) == 1 else colour
        for name in commands:  # each holds until the next
            axes.step(*_trace(drive, name), where="post", color=said, ls=DASHED, lw=0.9, zorder=2.4)


def _trace(drive: RecordedDrive, name: str) -> tuple[Floats, Floats]:
    """Times and values of a column; empty if the drive lacks it."""
    return drive.times.get(name, NOTHING), drive.columns.get(name, NOTHING)
