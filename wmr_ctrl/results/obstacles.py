"""Obstacles: circles and polygons that a body must not touch, and a run's distance from them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from types import ModuleType
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import casadi as ca

    from .run import Run

Floats: TypeAlias = NDArray[np.float64]
N = TypeVar("N", Floats, "ca.SX")
Shape: TypeAlias = tuple[float, ...] | tuple[tuple[float, float], ...]
"""A circle (x, y, r) or the corners of a polygon [m]."""


def distance(shape: Shape, x: N, y: N, of: ModuleType = np) -> N:
    """Distance [m] of places (x, y) from a circle or polygon; below 0 or 0 inside of it.

    ``of``: the module of their functions, numpy or, for expressions, casadi.
    """
    if not isinstance(shape[0], tuple):
        return of.sqrt((x - shape[0]) ** 2 + (y - shape[1]) ** 2) - shape[2]
    squares, side = [], 1
    for (ax, ay), (bx, by) in zip(shape, (*shape[1:], shape[0]), strict=True):
        dx, dy, to_x, to_y = bx - ax, by - ay, x - ax, y - ay
        along = (to_x * dx + to_y * dy) / max(dx * dx + dy * dy, 1e-300)
        share = of.fmax(0.0, of.fmin(1.0, along))
        squares.append((to_x - share * dx) ** 2 + (to_y - share * dy) ** 2)
        if dy:
            crossed = ((ay > y) != (by > y)) * (to_x < to_y * (dx / dy))
            side = side * (1 - 2 * crossed)
    return side * of.sqrt(reduce(of.fmin, squares))


def closest(shapes: Sequence[Shape], points: Floats) -> tuple[float, int, int]:
    """Smallest distance [m] of ``points`` (N, 2) from any shape; index of shape and point."""
    away = np.array([distance(shape, *points.T) for shape in shapes])
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
