"""Long traces, thinned without losing a peak."""

from __future__ import annotations

import numpy as np

from wmr_ctrl.results import FloatArray

POINTS = 1500
"""Points of a drawn trace; more cannot be told apart on a page."""


def thin(t: FloatArray, y: FloatArray, points: int = POINTS) -> tuple[FloatArray, FloatArray]:
    """At most ``points`` samples of y(t): the least and the greatest of each stretch, in order.

    ``t`` and ``y`` have the shape (N,); short traces and their NaN pass unchanged.
    """
    count = len(t)
    stretches = points // 2
    if count <= points or stretches < 1:
        return t, y
    size = -(-count // stretches)
    padded = np.full(size * -(-count // size), np.nan)
    padded[:count] = y
    parts = padded.reshape(-1, size)
    start = size * np.arange(len(parts))
    low = start + np.argmin(np.where(np.isnan(parts), np.inf, parts), axis=1)
    high = start + np.argmax(np.where(np.isnan(parts), -np.inf, parts), axis=1)
    rows = np.unique(np.concatenate(([0], low, high, [count - 1])))
    rows = rows[rows < count]
    return t[rows], y[rows]


def running_mean(values: FloatArray, width: int) -> FloatArray:
    """Centred mean over ``width`` values, fewer at the ends, shape (N,)."""
    total = np.concatenate(([0.0], np.cumsum(values)))
    index = np.arange(len(values))
    low = np.maximum(index - width // 2, 0)
    high = np.minimum(index + width - width // 2, len(values))
    return np.asarray((total[high] - total[low]) / (high - low))


def running_rms(values: FloatArray, width: int) -> FloatArray:
    """Centred RMS over ``width`` values, fewer at the ends, shape (N,)."""
    return np.asarray(np.sqrt(np.maximum(running_mean(values**2, width), 0.0)))


def thin_path(x: FloatArray, y: FloatArray, points: int = POINTS) -> tuple[FloatArray, FloatArray]:
    """At most ``points`` points of a path in the plane, denser where it moves fast.

    Points are spread evenly over path length and sample number together; the ends are kept.
    """
    count = len(x)
    if count <= points:
        return x, y
    length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    share = length / (length[-1] or 1.0) + np.arange(count) / (count - 1)
    rows = np.unique(np.searchsorted(share, np.linspace(0.0, share[-1], points)))
    rows = np.unique(np.concatenate(([0], np.minimum(rows, count - 1), [count - 1])))
    return x[rows], y[rows]
