"""Panel (a): the paths in the plane, and their beginning enlarged."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from wmr_ctrl.report.canvas import Margins, Place, row_of_axes
from wmr_ctrl.report.decimate import thin_path
from wmr_ctrl.report.panels.base import Group
from wmr_ctrl.report.style import DOTTED, INK, MUTED, look
from wmr_ctrl.results import Run

START = 3.0
"""Length of the beginning that is shown enlarged [s]."""


def draw_trajectory(place: Place, group: Group, margins: Margins) -> None:
    """Paths of all laws with their reference; on the right the first seconds; equal scales."""
    whole, start = row_of_axes(place, margins, (1.0, 1.0), 0.45)
    draw_paths(whole, group, 800)
    draw_paths(start, group, 8000)
    whole.set(xlabel="x [m]", ylabel="y [m]")
    start.set(xlabel=f"x [m], first {START:g} s")
    whole.set_aspect("equal", adjustable="datalim")
    frame = _frame(group)
    start.set(xlim=frame[:2], ylim=frame[2:])
    start.set_aspect("equal", adjustable="box")
    size = frame[1] - frame[0], frame[3] - frame[2]
    whole.add_patch(Rectangle(frame[::2], *size, fill=False, ec=MUTED, lw=0.6, zorder=3))


def draw_paths(axes: Axes, group: Group, points: int = 800) -> None:
    """The reference, dotted, then each law's path, and a ring where the robot starts."""
    any_run = next(iter(group.values()))
    axes.plot(*thin_path(any_run["x_d"], any_run["y_d"], 400), color=MUTED, ls=DOTTED, lw=1.4)
    for law, run in group.items():
        seen = look(law)
        axes.plot(*thin_path(run["x"], run["y"], points), color=seen.colour, ls=seen.dash, lw=1.1)
    axes.plot(any_run["x"][0], any_run["y"][0], "o", mfc="white", mec=INK, ms=4.5, zorder=4)


def _frame(group: Group) -> tuple[float, float, float, float]:
    """A square around all paths of the first seconds: x from, x to, y from, y to [m]."""
    x, y = (np.concatenate([_early(run, name) for run in group.values()]) for name in "xy")
    half = 0.55 * max(np.ptp(x), np.ptp(y), 0.1)
    centre = (x.min() + x.max()) / 2, (y.min() + y.max()) / 2
    return (
        float(centre[0] - half), float(centre[0] + half),
        float(centre[1] - half), float(centre[1] + half),
    )  # fmt: skip


def _early(run: Run, name: str) -> np.ndarray:
    """A coordinate of the robot and of its reference over the first seconds."""
    rows = slice(0, run.settings.index(START))
    return np.concatenate([run[name][rows], run[f"{name}_d"][rows]])
