"""Obstacles: circles and polygons that a body must not touch, and a run's distance from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .run import Run

Floats: TypeAlias = NDArray[np.float64]
Shape: TypeAlias = tuple[float, ...] | tuple[tuple[float, float], ...]
"""A circle (x, y, r) or the corners of a polygon [m]."""


def distance(shape: Shape, points: Floats) -> Floats:
    """Distance [m] of ``points`` (N, 2) from a circle or polygon; below 0 or 0 inside of it."""
    if not isinstance(shape[0], tuple):
        x, y, radius = shape
        return np.hypot(points[:, 0] - x, points[:, 1] - y) - radius
    corners = np.array(shape)
    inside, nearest = np.zeros(len(points), dtype=bool), np.full(len(points), np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        side, to = b - a, points - a
        along = np.clip(to @ side / max(side @ side, 1e-300), 0.0, 1.0)
        nearest = np.minimum(nearest, np.hypot(*(to - np.outer(along, side)).T))
        crossed = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            at = a[0] + (points[:, 1] - a[1]) * side[0] / side[1]
        inside ^= crossed & (points[:, 0] < at)
    return np.where(inside, -nearest, nearest)


def closest(shapes: Sequence[Shape], points: Floats) -> tuple[float, int, int]:
    """Smallest distance [m] of ``points`` (N, 2) from any shape; index of shape and point."""
    away = np.array([distance(shape, points) for shape in shapes])
    place, k = np.unravel_index(away.argmin(), away.shape)
    return float(away[place, k]), int(place), int(k)


def nearest(run: Run) -> tuple[float, int, float] | None:
    """Smallest gap [m] between body and obstacle over the samples; the obstacle, from 1, and time
    [s].

    The body is a disc of `Settings.radius` about the axle's midpoint; below 0 it touches.  None
    without obstacles or samples.
    """
    settings = run.settings
    if not settings.keep_out or settings.radius is None or not run.rows:
        return None
    points = np.stack([run["x"], run["y"]], axis=1)
    away, place, k = closest(settings.keep_out, points)
    return away - settings.radius, place + 1, float(run.time[k])
