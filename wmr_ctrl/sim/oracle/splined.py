"""Motion along a fitted spline: its table of polynomials, evaluated one point at a time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable

from wmr_ctrl.sim.oracle.target import DesiredState, Pair, target_on
from wmr_ctrl.world.references.spline import SplinePath


def splined(path: SplinePath) -> Callable[[float], DesiredState]:
    """The function of time t [s] that follows a spline path."""
    return lambda t: along(path, t)


def along(path: SplinePath, t: float) -> DesiredState:
    """A closed path is repeated; an open one goes on straight ahead after its end."""
    if path.closed:
        lap = math.floor(t / path.duration)
        return _on_path(path, t - lap * path.duration, lap * path.turn)
    return _on_path(path, t, 0.0) if t <= path.duration else _beyond(path, t - path.duration)


def _on_path(path: SplinePath, t: float, turned: float) -> DesiredState:
    """Target at time ``t`` of the first lap, its orientation increased by ``turned``."""
    knots = path.knots
    i = min(max(bisect_right(knots, t) - 1, 0), len(knots) - 2)
    length = float(knots[i + 1] - knots[i])
    s = (t - float(knots[i])) / length
    place, rate, rate2, rate3 = (_derivative(path, i, s, n, length) for n in range(4))
    middle = float(path.headings[i])
    theta = math.atan2(rate[1], rate[0]) - math.pi / 2.0
    theta = middle + math.remainder(theta - middle, 2.0 * math.pi)  # the branch of the segment
    return target_on(place, theta + turned, rate, rate2, rate3)


def _derivative(path: SplinePath, i: int, s: float, order: int, length: float) -> Pair:
    """Derivative by time of segment ``i`` at its local parameter ``s``."""
    x = y = 0.0
    for power in range(path.coefficients.shape[1] - 1, order - 1, -1):
        factor = math.perm(power, order)
        x = x * s + factor * float(path.coefficients[i, power, 0])
        y = y * s + factor * float(path.coefficients[i, power, 1])
    return x / length**order, y / length**order


def _beyond(path: SplinePath, late: float) -> DesiredState:
    """Straight on at the last velocity, ``late`` seconds after the end of an open path."""
    end = _on_path(path, path.duration, 0.0)
    x = end.x - late * end.v1 * math.sin(end.theta)
    y = end.y + late * end.v1 * math.cos(end.theta)
    return DesiredState(x, y, end.theta, end.v1, 0.0, 0.0, 0.0)
