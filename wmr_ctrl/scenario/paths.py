"""The spline paths behind rounded squares and waypoints, checked for what a robot can follow."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.scenario.reference import RoundedSquare, Waypoints
from wmr_ctrl.scenario.spline import SAMPLES, Array, SplinePath, fit, headings
from wmr_ctrl.scenario.square import square_points

MOST_POINTS = 400
SAME = 1e-9
"""Points nearer to each other than this, m, are the same."""
SLOWEST = 0.1
"""Smallest share of the wanted speed that a path may fall to: below it turns on the spot."""
SHARPEST = math.pi / 4
"""Largest turn, rad, between two of the samples on a segment."""
WIDEST = 3.0
"""Largest turn, rad, from the middle of a segment to either end."""


@lru_cache(maxsize=64)
def path_of(reference: RoundedSquare | Waypoints) -> SplinePath:
    """Return the spline path of a rounded square or of waypoints; the speed on it is above 0.

    Raises ScenarioError if the points do not make a path that can be driven forwards.
    """
    if isinstance(reference, RoundedSquare):
        return fit(square_points(reference.side, reference.corner), reference.speed, True)
    points = _checked_points(reference)
    try:
        path = fit(points, reference.speed, reference.closed)
    except (ValueError, np.linalg.LinAlgError) as problem:
        raise ScenarioError(
            f"reference.points: no smooth path runs through them ({problem}). "
            "Space them more evenly."
        ) from None
    _check_forward(path, reference.speed)
    return path


def _checked_points(reference: Waypoints) -> Array:
    points = list(reference.points)
    if reference.closed and len(points) > 1 and _distance(points[0], points[-1]) < SAME:
        points.pop()
    _check_count(points, 3 if reference.closed else 2, reference.closed)
    for i in range(1, len(points)):
        if _distance(points[i - 1], points[i]) < SAME:
            raise ScenarioError(
                f"reference.points[{i}] and reference.points[{i + 1}] are the same point "
                f"{points[i]}: the path has no direction there. Remove one of them."
            )
    return np.array(points, dtype=float)


def _check_count(points: list[tuple[float, float]], least: int, closed: bool) -> None:
    shape = "a closed path" if closed else "a path"
    if len(points) < least:
        raise ScenarioError(
            f"reference.points has {len(points)} different point(s), but {shape} needs at least "
            f"{least}. Add points, as x, y in m."
        )
    if len(points) > MOST_POINTS:
        raise ScenarioError(
            f"reference.points has {len(points)} points; at most {MOST_POINTS} are possible. "
            "Thin them out: the path between them is smooth."
        )


def _distance(a: tuple[float, float], b: tuple[float, float]) -> float:
    return float(np.hypot(a[0] - b[0], a[1] - b[1]))


def _check_forward(path: SplinePath, speed: float) -> None:
    """Refuse a path that nearly stops to turn; where it does not, theta_d's branch is certain."""
    velocity = path.derivatives(1, np.linspace(0, 1, SAMPLES + 1))
    share = np.hypot(velocity[..., 0], velocity[..., 1]) / speed
    theta = headings(path.coefficients)
    steps = np.abs(np.diff(theta, axis=1)).max(axis=1)
    reach = np.abs(theta - path.headings[:, None]).max(axis=1)
    good = (share.min(axis=1) >= SLOWEST) & (steps <= SHARPEST) & (reach <= WIDEST)
    if not good.all():
        segment = int(np.argmin(good))
        sample = int(np.argmin(share[segment]))
        point = (segment + round(sample / SAMPLES)) % (len(good) + (not path.closed)) + 1
        raise ScenarioError(
            f"reference.points[{point}]: the smooth path turns almost on the spot near this point "
            f"(at {100 * share[segment, sample]:.2g} % of reference.speed), which a robot that "
            "drives forwards cannot follow. Add points that round the turn."
        )
