"""Scene of an animation: poses at the times of the frames, and a painter of frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from numpy.typing import NDArray

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.report.style import DOTTED, INK, LIMIT, MUTED, driver, house_style, look, verbatim
from wmr_ctrl.results import FloatArray, Run

BODY = (0.8, 0.5)
"""Length and width of the robot's body [m], those of the paper's Section VI."""

WHEEL = (0.2, 0.05)
"""Length and width of a wheel [m]."""

TRACK = 0.25
"""Axle's midpoint to a wheel [m]."""


@dataclass(frozen=True)
class Scene:
    """Columns of a run at evenly spaced samples, each of shape (frames,).

    ``view`` is x from, x to, y from, y to [m].
    """

    run: Run
    t: FloatArray
    pose: FloatArray
    target: FloatArray
    velocity: FloatArray
    view: tuple[float, float, float, float]

    @property
    def limits(self) -> tuple[float, float]:
        """Limits of |v1| [m/s] and |omega| [rad/s]."""
        return self.run.settings.v_u1


def scene_of(run: Run, frames: int) -> Scene:
    """At most ``frames`` frames of a run, the last sample among them.

    ``pose`` and ``target`` have the shape (frames, 3): x, y [m], theta [rad]; ``velocity`` (frames,
    2): v1 [m/s], omega [rad/s].  Raises ArgumentError for a run without any sample.
    """
    if not run.rows:
        raise ArgumentError("the run has no sample to show: it ended before the first one.")
    step = max(1, -(-run.rows // frames))
    rows = np.unique(np.append(np.arange(0, run.rows, step), run.rows - 1))

    def columns(*names: str) -> FloatArray:
        return np.column_stack([run[name][rows] for name in names])

    pose, target = columns("x", "y", "theta"), columns("x_d", "y_d", "theta_d")
    points = np.concatenate((pose[:, :2], target[:, :2]))
    low, high = points.min(axis=0), points.max(axis=0)
    half = float(max(high - low)) / 2 + 0.7  # room for the robot's body
    x, y = ((low + high) / 2).tolist()
    view = x - half, x + half, y - half, y + half
    return Scene(run, run.time[rows], pose, target, columns("v1", "omega"), view)


def outline(pose: FloatArray, length: float, width: float, aside: float = 0.0) -> FloatArray:
    """Corners of a rectangle that moves with the robot, shape (4, 2) [m].

    ``pose`` is x, y, theta with theta = 0 along +Y; ``aside`` [m] moves it to the right.
    """
    ahead = np.array([-np.sin(pose[2]), np.cos(pose[2])])
    right = np.array([ahead[1], -ahead[0]])
    centre = pose[:2] + aside * right
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) / 2
    return np.asarray(centre + signs[:, :1] * length * ahead + signs[:, 1:] * width * right)


_DPI = 100
_SIZE = (5.6, 6.2)
"""Width and height [inch]; both an even number of pixels, as films want them."""
FRAME = (round(_SIZE[0] * _DPI), round(_SIZE[1] * _DPI))
"""The same in pixels."""
Picture: TypeAlias = NDArray[np.uint8]
"""Rows, columns, colours."""


def frames(scene: Scene) -> Iterator[Picture]:
    """One picture per frame, shape (620, 560, 3)."""
    with house_style():
        stage = _Stage(scene)
        for index in range(len(scene.t)):
            yield stage.picture(index)


class _Stage:
    """Axes whose background is drawn once; per frame only the moving artists are drawn."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._figure = Figure(figsize=_SIZE, dpi=_DPI)
        self._canvas = FigureCanvasAgg(self._figure)
        self._colour = look(scene.run.law).colour
        plane = self._figure.add_axes((0.1, 0.215, 0.87, 0.745))
        self._set_up_plane(plane)
        self._bars = [self._bar(axis) for axis in (0, 1)]
        self._moving = self._movers(plane)
        self._canvas.draw()
        self._background = self._canvas.copy_from_bbox(self._figure.bbox)

    def picture(self, index: int) -> Picture:
        """The frame of a row of the scene."""
        self._place(index)
        self._canvas.restore_region(self._background)
        for artist in self._moving:
            artist.draw(self._canvas.get_renderer())
        return np.array(self._canvas.buffer_rgba())[:, :, :3]

    def _set_up_plane(self, axes: Axes) -> None:
        scene, left, right, low, high = self._scene, *self._scene.view
        axes.set(xlim=(left, right), ylim=(low, high), xlabel="x [m]", ylabel="y [m]")
        axes.set_aspect("equal", adjustable="box")
        axes.plot(scene.target[:, 0], scene.target[:, 1], color=MUTED, ls=DOTTED, lw=1.2)
        run = scene.run
        axes.set_title(f"{driver(run.law, run.guard)}, {verbatim(run.scenario)}, seed {run.seed}")

    def _bar(self, axis: int) -> Rectangle:
        """A bar from zero to the velocity, in units of its limit; the limits are marked."""
        axes = self._figure.add_axes((0.2, 0.085 - 0.055 * axis, 0.77, 0.035))
        axes.set(xlim=(-1.5, 1.5), ylim=(0, 1), yticks=(), xticks=())
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.axvspan(-1, 1, color="#eef1f4", lw=0)
        axes.axvline(0, color=MUTED, lw=0.6)
        for edge in (-1, 1):
            axes.axvline(edge, color=LIMIT, lw=1.4)
        limit, unit = self._scene.limits[axis], ("m/s", "rad/s")[axis]
        axes.set_ylabel(f"{('v₁', 'ω')[axis]}, limit\n±{limit:g} {unit}", rotation=0, ha="right",
                        va="center", size=7, labelpad=6)  # fmt: skip
        bar = Rectangle((0, 0.15), 0, 0.7, color=self._colour, animated=True)
        axes.add_patch(bar)
        return bar

    def _movers(self, axes: Axes) -> list[Artist]:
        """The artists of a frame, from back to front."""
        square = np.zeros((4, 2))
        self._trail = axes.plot([], [], color=self._colour, lw=1.3, animated=True)[0]
        self._ghost = Polygon(square, fill=False, ec=MUTED, ls="--", lw=1.0, animated=True)
        self._body = Polygon(square, fc=self._colour, ec=INK, alpha=0.35, lw=1.0, animated=True)
        self._wheels = [Polygon(square, fc=INK, lw=0, animated=True) for _ in "rl"]
        self._nose = axes.plot([], [], color=INK, lw=2.0, solid_capstyle="round", animated=True)[0]
        self._clock = axes.text(0.98, 0.98, "", ha="right", va="top", size=10,
                                transform=axes.transAxes, animated=True)  # fmt: skip
        for patch in (self._ghost, self._body, *self._wheels):
            axes.add_patch(patch)
        return [self._trail, self._ghost, self._body, *self._wheels, self._nose, self._clock,
                *self._bars]  # fmt: skip

    def _place(self, index: int) -> None:
        scene, pose = self._scene, self._scene.pose[index]
        self._trail.set_data(scene.pose[: index + 1, 0], scene.pose[: index + 1, 1])
        self._ghost.set_xy(outline(scene.target[index], *BODY))
        self._body.set_xy(outline(pose, *BODY))
        for wheel, side in zip(self._wheels, (1, -1), strict=True):
            wheel.set_xy(outline(pose, *WHEEL, side * TRACK))
        nose = pose[:2] + np.outer((0.0, BODY[0] / 2), (-np.sin(pose[2]), np.cos(pose[2])))
        self._nose.set_data(nose[:, 0], nose[:, 1])
        self._clock.set_text(f"t = {scene.t[index]:.1f} s")
        for axis, bar in enumerate(self._bars):
            share = float(scene.velocity[index, axis] / scene.limits[axis])
            bar.set_width(float(np.clip(share, -1.5, 1.5)))
            bar.set_color(LIMIT if abs(share) > 1 else self._colour)
