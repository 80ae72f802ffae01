"""Scene of an animation: poses at the times of the frames, and a painter of frames."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from numpy.typing import NDArray

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.fields.orientation import ORIENTATIONS, inward
from wmr_ctrl.report.course import Course, course_of
from wmr_ctrl.report.drawing import line_handle
from wmr_ctrl.report.style import (
    DASHES,
    DOTTED,
    INK,
    LIMIT,
    MUTED,
    Dash,
    colours_of,
    driver,
    house_style,
    verbatim,
)
from wmr_ctrl.results import FloatArray, Run
from wmr_ctrl.results.drive import POSES, SPEEDS, RecordedDrive

BODY = (0.8, 0.5)
"""Length and width of the robot's body [m], those of the paper's Section VI."""

WHEEL = (0.2, 0.05)
"""Length and width of a wheel [m]."""

TRACK = 0.25
"""Axle's midpoint to a wheel [m]."""
_POSE, _TARGET, _V = ("x", "y", "theta"), ("x_d", "y_d", "theta_d"), ("v1", "omega")
_SAME = 1e-6
"""References this near [m, rad] are one: runs of other periods sample them at other times."""
_DPI = 100
_SIZE = (5.6, 6.2)
"""Width and height [inch]; both an even number of pixels, as films want them."""
Picture: TypeAlias = NDArray[np.uint8]
"""Rows, columns, colours."""


@dataclass(frozen=True)
class Actor:
    """A robot of an animation: its name, colour, and poses and velocities at the frames.

    ``pose`` (frames, 3): x, y [m], theta [rad]; ``velocity`` (frames, 2): v1 [m/s], omega [rad/s].
    """

    label: str
    colour: str
    pose: FloatArray
    velocity: FloatArray


@dataclass(frozen=True)
class Scene:
    """Robots and desired pose at evenly spaced times ``t`` [s] of shape (frames,).

    ``target`` has the shape (frames, 3) of a pose; None: nobody knows it.  ``scales`` of |v1| [m/s]
    and |omega| [rad/s] are the limits of all where these are ``limited``, else the largest that
    occur.  ``view`` is x from, x to, y from, y to [m].
    ``course``: what the map shows beside the paths.
    """

    title: str
    actors: tuple[Actor, ...]
    t: FloatArray
    target: FloatArray | None
    scales: tuple[float, float]
    view: tuple[float, float, float, float]
    limited: bool = True
    course: Course = field(default_factory=Course)

    @property
    def size(self) -> float:
        """Size of the robots relative to BODY, WHEEL and TRACK."""
        return (self.course.half_track or TRACK) / TRACK


def scene_of(runs: Sequence[Run], frames: int, labels: Sequence[str] = ()) -> Scene:
    """At most ``frames`` frames of runs side by side, the last sample of the longest among them.

    A robot whose run ended early stays where it was.  Raises ArgumentError for a run without any
    sample, and for runs with other limits or another reference than the first.
    """
    for run in runs:
        if not run.rows:
            raise ArgumentError("the run has no sample to show: it ended before the first one.")
    longest = max(runs, key=lambda run: float(run.time[-1]))
    step = max(1, -(-longest.rows // frames))
    rows = np.unique(np.append(np.arange(0, longest.rows, step), longest.rows - 1))
    t, target = longest.time[rows], _columns(longest, rows, *_TARGET)
    actors = []
    colours = colours_of([run.law for run in runs])
    for run, label, colour in zip(runs, labels or names_of(runs), colours, strict=True):
        held = np.searchsorted(run.time, t + 1e-9, side="right") - 1
        shared = t <= run.time[-1]
        near = np.isclose(_columns(run, held, *_TARGET), target, rtol=0, atol=_SAME)
        if run.settings.v_u1 != longest.settings.v_u1 or not near[shared].all():
            raise ArgumentError(
                "the runs have different limits or follow different references, so that one "
                "picture cannot show them together. Draw each by `wmr-ctrl show RUN --plot FILE`."
            )
        actors.append(Actor(label, colour, _columns(run, held, *_POSE), _columns(run, held, *_V)))
    names = f"{actors[0].label}, " if len(actors) == 1 else ""
    title = f"{names}{longest.scenario}, seed {longest.seed}"
    course = course_of(longest)
    view = _view([target, *(one.pose for one in actors)], course)
    limits = longest.settings.v_u1
    return Scene(title, tuple(actors), t, target, limits, view, course=course)


def scene_of_drives(drives: Sequence[RecordedDrive], frames: int) -> Scene:
    """At most ``frames`` frames of drives, which know neither a desired pose nor limits.

    A robot stands where it was first or last seen; between two messages it moves evenly.  Raises
    ArgumentError, by name, for a drive without poses and velocities.
    """
    for drive in drives:
        lacking = [name for name in (*POSES, *SPEEDS) if not drive.has([name])]
        if lacking:
            raise ArgumentError(
                f"{drive.name} has no {', '.join(lacking)}, and a moving picture shows the pose "
                "with its velocities: leave out --animate. `wmr-ctrl show` lists what it has."
            )
    t = np.linspace(0.0, max(drive.duration for drive in drives), frames)
    actors = []
    colours = colours_of([drive.name for drive in drives])
    for drive, colour in zip(drives, colours, strict=True):
        rows = [np.interp(t, drive.times[name], drive.columns[name]) for name in (*POSES, *SPEEDS)]
        moving = np.column_stack(rows)
        actors.append(Actor(drive.name, colour, moving[:, :3], moving[:, 3:]))
    v, omega = (
        max(float(np.abs(drive.columns[name]).max()) for drive in drives) or 1.0 for name in SPEEDS
    )
    view = _view([one.pose for one in actors], Course())
    title = actors[0].label if len(actors) == 1 else "drives"
    return Scene(title, tuple(actors), t, None, (v, omega), view, limited=False)


def _view(poses: Sequence[FloatArray], course: Course) -> tuple[float, float, float, float]:
    """A square with all poses and waypoints, and room for the robot's body."""
    points = np.concatenate([part[:, :2] for part in poses])
    points = np.concatenate([points, np.reshape(course.waypoints, (-1, 2))])
    low, high = points.min(axis=0), points.max(axis=0)
    half = float(max(high - low)) / 2 + 0.7 * (course.half_track or TRACK) / TRACK
    x, y = ((low + high) / 2).tolist()
    return x - half, x + half, y - half, y + half


def _columns(run: Run, rows: NDArray[np.intp], *names: str) -> FloatArray:
    frames = run.settings.frames
    columns = (run[name] for name in names)
    return np.column_stack(
        [
            (inward(column, frames) if name in ORIENTATIONS else column)[rows]
            for name, column in zip(names, columns, strict=True)
        ]
    )


def names_of(runs: Sequence[Run]) -> list[str]:
    """Law and guard of each run, with its seed where two have the same."""
    names = [driver(run.law, run.guard) for run in runs]
    return [
        f"{name}, seed {run.seed}" if names.count(name) > 1 else name
        for name, run in zip(names, runs, strict=True)
    ]


def outline(pose: FloatArray, length: float, width: float, aside: float = 0.0) -> FloatArray:
    """Corners of a rectangle that moves with the robot, shape (4, 2) [m].

    ``pose`` is x, y, theta with theta = 0 along +Y; ``aside`` [m] moves it to the right.
    """
    ahead = np.array([-np.sin(pose[2]), np.cos(pose[2])])
    right = np.array([ahead[1], -ahead[0]])
    centre = pose[:2] + aside * right
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) / 2
    return np.asarray(centre + signs[:, :1] * length * ahead + signs[:, 1:] * width * right)


FRAME = (round(_SIZE[0] * _DPI), round(_SIZE[1] * _DPI))
"""The same in pixels."""


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
        self._bars = [self._bars_of(axis) for axis in (0, 1)]
        self._ghost = Polygon(_SQUARE, fill=False, ec=MUTED, ls="--", lw=1.0, animated=True)
        plane.add_patch(self._ghost)
        self._robots = [
            _Robot(plane, actor, DASHES[place % len(DASHES)], scene.size)
            for place, actor in enumerate(scene.actors)
        ]
        self._clock = self._figure.text(0.97, 0.992, "", ha="right", va="top", size=10,
                                        animated=True)  # fmt: skip
        parts = [artist for robot in self._robots for artist in robot.artists]
        ghost = [] if scene.target is None else [self._ghost]
        self._moving = [*ghost, *parts, self._clock, *self._bars[0], *self._bars[1]]
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
        if scene.target is not None:
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

    def _bars_of(self, axis: int) -> list[Rectangle]:
        """A bar a robot, from zero to its velocity in units of the scale, which is marked."""
        axes = self._figure.add_axes((0.2, 0.085 - 0.055 * axis, 0.77, 0.035))
        axes.set(xlim=(-1.5, 1.5), ylim=(0, 1), yticks=(), xticks=())
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
        axes.axvspan(-1, 1, color="#eef1f4", lw=0)
        axes.axvline(0, color=MUTED, lw=0.6)
        limited, unit = self._scene.limited, ("m/s", "rad/s")[axis]
        for edge in (-1, 1):
            axes.axvline(edge, color=LIMIT if limited else MUTED, lw=1.4)
        word = "limit" if limited else "largest"
        text = f"{('v₁', 'ω')[axis]}, {word}\n±{self._scene.scales[axis]:.4g} {unit}"
        axes.set_ylabel(text, rotation=0, ha="right", va="center", size=7, labelpad=6)
        actors = self._scene.actors
        high = 0.7 / len(actors)
        bars = [
            Rectangle((0, 0.85 - high * (place + 1)), 0, high, color=one.colour, animated=True)
            for place, one in enumerate(actors)
        ]
        for bar in bars:
            axes.add_patch(bar)
        return bars

    def _place(self, index: int) -> None:
        scene = self._scene
        if scene.target is not None:
            self._ghost.set_xy(outline(scene.target[index], *(scene.size * np.array(BODY))))
        self._clock.set_text(f"t = {scene.t[index]:.1f} s")
        for place, (robot, actor) in enumerate(zip(self._robots, scene.actors, strict=True)):
            robot.place(index)
            for axis in (0, 1):
                share = float(actor.velocity[index, axis] / scene.scales[axis])
                bar = self._bars[axis][place]
                bar.set_width(float(np.clip(share, -1.5, 1.5)))
                bar.set_color(LIMIT if scene.limited and abs(share) > 1 else actor.colour)


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
