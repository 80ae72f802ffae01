"""What moves: poses at the times of the frames, and the part of the plane that they need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.errors import ArgumentError
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

    ``view`` is x from, x to, y from, y to [m]; ``limits`` are those of |v1| [m/s] and
    |omega| [rad/s].
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

    pose = columns("x", "y", "theta")
    target = columns("x_d", "y_d", "theta_d")
    velocity = columns("v1", "omega")
    return Scene(run, run.time[rows], pose, target, velocity, _view(pose, target))


def _view(pose: FloatArray, target: FloatArray) -> tuple[float, float, float, float]:
    """A square around both paths, with room for the robot's body."""
    points = np.concatenate((pose[:, :2], target[:, :2]))
    low, high = points.min(axis=0), points.max(axis=0)
    half = float(max(high - low)) / 2 + 0.7
    x, y = ((low + high) / 2).tolist()
    return x - half, x + half, y - half, y + half


def outline(pose: FloatArray, length: float, width: float, aside: float = 0.0) -> FloatArray:
    """Corners of a rectangle that moves with the robot, shape (4, 2) [m].

    ``pose`` is x, y, theta with theta = 0 along +Y; ``aside`` [m] moves it to the right.
    """
    ahead = np.array([-np.sin(pose[2]), np.cos(pose[2])])
    right = np.array([ahead[1], -ahead[0]])
    centre = pose[:2] + aside * right
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) / 2
    return np.asarray(centre + signs[:, :1] * length * ahead + signs[:, 1:] * width * right)
