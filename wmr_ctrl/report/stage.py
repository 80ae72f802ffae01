"""Painter of an animation's frames: the map with the robots, and gauges below it."""

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from .course import FAINT
from .drawing import line_handle
from .scene import BODY, TRACK, WHEEL, Actor, Scene, outline
from .style import DASHES, DOTTED, GRID, INK, LIMIT, MUTED, Dash, house_style, verbatim

_DPI = 100
_SIZE = (5.6, 6.2)
"""Width and height [inch]."""
_GAUGES = (0.2, 0.03, 0.77, 0.1)
_BEYOND = 1.5
"""Range of the gauges, in units of the limits."""
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
        top = 0.935 if len(scene.actors) > 1 else 0.955
        plane = self._figure.add_axes((0.1, 0.215, 0.87, top - 0.215))
        self._set_up_plane(plane)
        gauges = self._figure.add_axes(_GAUGES)
        self._bars = self._set_up_gauges(gauges)
        self._ghost = Polygon(_SQUARE, fill=False, ec=MUTED, ls="--", lw=1.0, animated=True)
        plane.add_patch(self._ghost)
        self._robots = [
            _Robot(plane, actor, DASHES[place % len(DASHES)], scene.size)
            for place, actor in enumerate(scene.actors)
        ]
        self._clock = self._figure.text(0.97, 0.992, "", ha="right", va="top", size=10,
                                        animated=True)  # fmt: skip
        parts = [artist for robot in self._robots for artist in robot.artists]
        bars = [bar for each in self._bars for bar in each]
        self._moving = [self._ghost, *parts, self._clock, *bars]
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
        for one in scene.actors:
            axes.fill(*scene.band(one), color=one.colour, alpha=FAINT, lw=0, zorder=1.4)
        axes.plot(*scene.target[:, :2].T, color=MUTED, ls=DOTTED, lw=1.2)
        scene.course.draw(axes)
        self._figure.text(0.1, 0.992, verbatim(scene.title), va="top", size=8.5, weight="bold")
        if len(scene.actors) > 1:
            handles = [
                line_handle(one.label, one.colour, dash=DASHES[place % len(DASHES)])
                for place, one in enumerate(scene.actors)
            ]
            axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1), ncols=7,
                        handlelength=2.6 if len(handles) < 5 else 1.5)  # fmt: skip

    def _set_up_gauges(self, axes: Axes) -> list[BarContainer]:
        """Two bars for each robot, v1 above omega, in shares of the limits."""
        v, omega = self._scene.scales
        words = f"v₁, limit\n±{v:.4g} m/s", f"ω, limit\n±{omega:.4g} rad/s"
        axes.set(xlim=(-_BEYOND, _BEYOND), ylim=(1.5, -0.5), xticks=())
        axes.set_yticks((0, 1), words)
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.axvspan(-1, 1, color=GRID)
        axes.vlines((-1, 1), -0.5, 1.5, color=LIMIT)
        high = 0.7 / len(self._scene.actors)
        return [
            axes.barh(np.arange(2) + high * place - 0.35, (0, 0), high, align="edge", animated=True)
            for place in range(len(self._scene.actors))
        ]

    def _place(self, index: int) -> None:
        scene = self._scene
        self._ghost.set_xy(outline(scene.target[index], *(scene.size * np.array(BODY))))
        self._clock.set_text(f"t = {scene.t[index]:.1f} s")
        for robot in self._robots:
            robot.place(index)
        for bars, one in zip(self._bars, scene.actors, strict=True):
            for bar, share in zip(bars, one.velocity[index] / scene.scales, strict=True):
                bar.set_width(share)
                bar.set_color(LIMIT if abs(share) > 1 else one.colour)


class _Robot:
    """Trail, body, wheels and nose of a robot."""

    def __init__(self, axes: Axes, actor: Actor, dash: Dash, size: float) -> None:
        self._pose, self._size = actor.pose, size
        self._trail = axes.plot([], [], color=actor.colour, ls=dash, lw=1.3, animated=True)[0]
        self._body = Polygon(_SQUARE, fc=actor.colour, ec=INK, alpha=0.35, lw=1.0, animated=True)
        self._wheels = [Polygon(_SQUARE, fc=INK, lw=0, animated=True) for _ in "rl"]
        self._nose = axes.plot([], [], color=INK, lw=2.0, solid_capstyle="round", animated=True)[0]
        for patch in (self._body, *self._wheels):
            axes.add_patch(patch)
        self.artists: list[Artist] = [self._trail, self._body, *self._wheels, self._nose]

    def place(self, index: int) -> None:
        """Move to the pose of a frame."""
        pose, size = self._pose[index], self._size
        self._trail.set_data(self._pose[: index + 1, 0], self._pose[: index + 1, 1])
        self._body.set_xy(outline(pose, size * BODY[0], size * BODY[1]))
        for wheel, side in zip(self._wheels, (1, -1), strict=True):
            wheel.set_xy(outline(pose, size * WHEEL[0], size * WHEEL[1], side * size * TRACK))
        ahead = -np.sin(pose[2]), np.cos(pose[2])
        nose = pose[:2] + np.outer((0.0, size * BODY[0] / 2), ahead)
        self._nose.set_data(nose[:, 0], nose[:, 1])


_SQUARE = np.zeros((4, 2))
"""Corners that a patch has before it is placed."""
