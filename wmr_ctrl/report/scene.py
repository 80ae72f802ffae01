"""Scene of an animation: poses at the frames' times, and readings of the gauges."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.orientation import ORIENTATIONS, inward
from wmr_ctrl.results import Floats, Run

from .course import Course, band, course_of, course_of_tube
from .style import colours_of, driver

BODY = (0.8, 0.5)
"""Length and width of the robot's body [m], those of the paper's Section VI."""
WHEEL = (0.2, 0.05)
"""Length and width of a wheel [m]."""
TRACK = 0.25
"""Axle's midpoint to a wheel [m]."""
_POSE, _TARGET, _V = ("x", "y", "theta"), ("x_d", "y_d", "theta_d"), ("v1", "omega")
_SAME = 1e-6
"""References this near [m, rad] are one: runs of other periods sample them at other times."""


@dataclass(frozen=True)
class Actor:
    """A robot of an animation: its name, colour, and poses and velocities at the frames.

    ``pose`` (frames, 3): x, y [m], theta [rad]; ``velocity`` (frames, 2): v1 [m/s], omega [rad/s].
    ``tube`` (frames,) [m]: width of its certified corridor, nan at frames without one; None if no
    frame has one.
    """

    label: str
    colour: str
    pose: Floats
    velocity: Floats
    tube: Floats | None = None


@dataclass(frozen=True)
class Scene:
    """Robots and desired pose at evenly spaced times ``t`` [s] of shape (frames,).

    ``target`` has the shape (frames, 3) of a pose. ``scales`` are the limits of |v1| [m/s] and
    |omega| [rad/s]. ``view`` is x from, x to, y from, y to [m]. ``course``: further parts of the
    map.
    """

    title: str
    actors: tuple[Actor, ...]
    t: Floats
    target: Floats
    scales: tuple[float, float]
    view: tuple[float, float, float, float]
    course: Course = field(default_factory=Course)

    @property
    def size(self) -> float:
        """Size of the robots relative to BODY, WHEEL and TRACK."""
        return (self.course.half_track or TRACK) / TRACK

    @property
    def tubes(self) -> bool:
        """True if a robot has a certified corridor."""
        return any(one.tube is not None for one in self.actors)

    def band(self, one: Actor) -> Floats:
        """Corners (2, m) of a robot's corridor about the path; none without one."""
        if one.tube is None:
            return np.empty((2, 0))
        return band(self.target[:, :2].T, one.tube)


def scene_of(runs: Sequence[Run], frames: int) -> Scene:
    """Scene of runs side by side, of up to ``frames`` frames, with the longest run's last sample.

    A robot whose run ended early keeps its last pose.  Raises ArgumentError for a run without any
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
    for run, label, colour in zip(runs, names_of(runs), colours, strict=True):
        held, shared = _held(run, t), t <= run.time[-1]
        near = np.isclose(_columns(run, held, *_TARGET), target, rtol=0, atol=_SAME)
        if run.settings.sides != longest.settings.sides or not near[shared].all():
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


def _held(run: Run, t: Floats) -> NDArray[np.intp]:
    """Rows of a run that are shown at times [s]."""
    return np.searchsorted(run.time, t + 1e-9, side="right") - 1


def with_tubes(scene: Scene, runs: Sequence[Run]) -> Scene:
    """The scene of runs with the certified corridor of each that has one."""
    actors = []
    for one, run in zip(scene.actors, runs, strict=True):
        course = course_of_tube(run)
        if course is not None:
            tube = np.where(scene.t <= run.time[-1], course[0, _held(run, scene.t)], math.nan)
            one = replace(one, tube=tube)
        actors.append(one)
    return replace(scene, actors=tuple(actors))


def _view(poses: Sequence[Floats], course: Course) -> tuple[float, float, float, float]:
    """A square that contains all poses and waypoints, with space for the robot's body."""
    points = np.concatenate([part[:, :2] for part in poses])
    points = np.concatenate([points, np.reshape(course.waypoints, (-1, 2))])
    low, high = points.min(axis=0), points.max(axis=0)
    half = float(max(high - low)) / 2 + 0.7 * (course.half_track or TRACK) / TRACK
    x, y = ((low + high) / 2).tolist()
    return x - half, x + half, y - half, y + half


def _columns(run: Run, rows: NDArray[np.intp], *names: str) -> Floats:
    frames = run.settings.frames
    columns = (run[name] for name in names)
    return np.column_stack(
        [
            (inward(column, frames) if name in ORIENTATIONS else column)[rows]
            for name, column in zip(names, columns, strict=True)
        ]
    )


def names_of(runs: Sequence[Run]) -> list[str]:
    """Law and guard of each run, with its seed if two would be equal."""
    names = [driver(run.law, run.guard) for run in runs]
    return [
        f"{name}, seed {run.seed}" if names.count(name) > 1 else name
        for name, run in zip(names, runs, strict=True)
    ]


def outline(pose: Floats, length: float, width: float, aside: float = 0.0) -> Floats:
    """Corners of a rectangle that moves with the robot, shape (4, 2) [m].

    ``pose`` is x, y, theta with theta = 0 along +Y; ``aside`` [m] moves it to the right.
    """
    ahead = np.array([-np.sin(pose[2]), np.cos(pose[2])])
    right = np.array([ahead[1], -ahead[0]])
    centre = pose[:2] + aside * right
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) / 2
    return np.asarray(centre + signs[:, :1] * length * ahead + signs[:, 1:] * width * right)
