"""Drives on one page: the path, and whatever else their bags have, over time."""

import os
from collections.abc import Callable, Sequence
from functools import partial
from math import ceil
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure, SubFigure

from wmr_ctrl.report.drawing import (
    Drawing,
    finish_path,
    heading,
    line_handle,
    one_axes,
    save_figure,
    target_of,
    thin,
    thin_path,
)
from wmr_ctrl.report.plot_run import MARGINS, SUFFIXES
from wmr_ctrl.report.style import DASHED, DOTTED, INK, MUTED, colours_of, house_style, verbatim
from wmr_ctrl.results import FloatArray
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

_WIDTH, _HEAD, _HIGH, _PATH = 8.3, 0.72, 1.9, 2.9
"""Width of the page; heights of its head, of a row, and of the row with the path [inch]."""
LEFT_OUT = f"A bag has no {NEVER.replace('V1', 'V₁')}."
PANELS: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...] = (
    ("v₁ [m/s]; dashed: as commanded", SPEEDS[:1], COMMANDS[:1]),
    ("ω [rad/s]; dashed: as commanded", SPEEDS[1:], COMMANDS[1:]),
    ("Wheel torques [N m]; right, dotted: left", TORQUES, ()),
    ("Wheel speeds [rad/s]; right, dotted: left", WHEEL_SPEEDS, ()),
    ("Wheel angles [rad]; right, dotted: left", WHEEL_ANGLE, ()),
)
"""Title, columns and commands of each picture over time; one that no drive has is left out."""
NOTHING: FloatArray = np.zeros(0)


def plot_drives(
    drives: Sequence[RecordedDrive], path: str | os.PathLike[str] | None = None
) -> Figure:
    """Draw drives over each other, into a .png, .svg or .pdf file too, whole or not at all.

    What none of them has is left out, and named.  Raises ResultFileError for another suffix or
    where the file cannot be written.
    """
    known = f"drives are drawn as {', '.join(SUFFIXES)}"
    target = None if path is None else target_of(path, SUFFIXES, known)
    with house_style():
        figure = page_of(drives).figure()
        if target is not None:
            save_figure(figure, target)
    return figure


def page_of(drives: Sequence[RecordedDrive]) -> Drawing:
    """The page as a drawing."""
    colours = colours_of([drive.name for drive in drives])
    panels: list[Callable[[SubFigure], None]] = []
    if any(drive.has(POSES) for drive in drives):
        panels.append(partial(_path, drives=drives, colours=colours))
    for title, measured, commands in PANELS:
        if any(drive.has([name]) for drive in drives for name in (*measured, *commands)):
            panels.append(
                partial(_over_time, drives=drives, colours=colours, title=title,
                        measured=measured, commands=commands)
            )  # fmt: skip
    rows = ceil(len(panels) / 2)
    heights = (_HEAD if len(drives) > 1 else _HEAD - 0.2, _PATH, *(_HIGH for _ in range(rows - 1)))
    draw = partial(_draw, drives=drives, colours=colours, panels=panels, heights=heights)
    return Drawing("drive", (_WIDTH, sum(heights)), draw)


def _draw(
    figure: Figure,
    drives: Sequence[RecordedDrive],
    colours: Sequence[str],
    panels: Sequence[Callable[[SubFigure], None]],
    heights: Sequence[float],
) -> None:
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights, hspace=0.0, wspace=0.0)
    top = figure.add_subfigure(grid[0, :])
    names = [verbatim(drive.name) for drive in drives]
    handles = [line_handle(*pair) for pair in zip(names, colours, strict=True)]
    heading(top, names[0] if len(drives) == 1 else "Drives", handles if len(drives) > 1 else ())
    nowhere = [name for name in drives[0].missing if all(name in one.missing for one in drives)]
    lacking = f" Nor is there {', '.join(nowhere)}." if nowhere else ""
    note = fill(LEFT_OUT + lacking, 150)
    top.text(0.06 / _WIDTH, 0.02, note, size=7.0, color=MUTED, va="bottom")
    for place, panel in enumerate(panels):
        panel(figure.add_subfigure(grid[1 + place // 2, place % 2]))


def _path(part: SubFigure, drives: Sequence[RecordedDrive], colours: Sequence[str]) -> None:
    """Paths as odometry has them, each with its start."""
    axes = one_axes(part, MARGINS)
    for drive, colour in zip(drives, colours, strict=True):
        if drive.has(POSES):
            x, y = (drive.columns[name] for name in POSES[:2])
            axes.plot(*thin_path(x, y, 3000), color=colour, lw=1.2, alpha=0.85)
            axes.plot(x[0], y[0], "o", mfc="white", mec=INK, ms=4.5, zorder=4)
    finish_path(axes, ["ring: start"])


def _over_time(
    part: SubFigure,
    drives: Sequence[RecordedDrive],
    colours: Sequence[str],
    title: str,
    measured: Sequence[str],
    commands: Sequence[str],
) -> None:
    axes = one_axes(part, MARGINS)
    axes.set(xlabel="t [s]", xlim=(0, max(drive.duration for drive in drives)))
    axes.set_title(title, weight="normal")
    for drive, colour in zip(drives, colours, strict=True):
        for name, dash in zip(measured, ("-", DOTTED), strict=False):
            axes.plot(*_trace(drive, name), color=colour, ls=dash, lw=0.9, alpha=0.8)
        said = INK if len(drives) == 1 else colour
        for name in commands:  # each holds until the next
            axes.step(*_trace(drive, name), where="post", color=said, ls=DASHED, lw=0.9, zorder=2.4)


def _trace(drive: RecordedDrive, name: str) -> tuple[FloatArray, FloatArray]:
    """Times and values of a column, none where the drive has it not."""
    return thin(drive.times.get(name, NOTHING), drive.columns.get(name, NOTHING))
