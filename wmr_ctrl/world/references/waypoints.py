"""Smooth path through given points, open or closed, checked for what a robot can follow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.problems import show
from wmr_ctrl.fields.section import quantity
from wmr_ctrl.world.references.csv_points import read_points
from wmr_ctrl.world.references.kind import Numbers, Raw, Reference, ReferenceKind, timed
from wmr_ctrl.world.references.spline import SAMPLES, Array, SplinePath, fit, headings
from wmr_ctrl.world.references.spline_motion import path_numbers, trajectory

MOST_POINTS = 400
SAME = 1e-9
"""Points nearer to each other than this, m, are the same."""
SLOWEST = 0.1
"""Smallest share of the wanted speed that a path may fall to: below it turns on the spot."""
SHARPEST = math.pi / 4
"""Largest turn, rad, between two of the samples on a segment."""
WIDEST = 3.0
"""Largest turn, rad, from the middle of a segment to either end."""


@dataclass(frozen=True, kw_only=True)
class Waypoints(Reference):
    """Smooth path (four continuous derivatives) through given points at nearly constant speed.

    An open path is left straight on, along its last tangent, when its end is reached before the
    run's.  A closed path returns from the last point to the first and is repeated.
    """

    points: tuple[tuple[float, float], ...] = quantity(
        (), unit="m", doc="x, y of each point, in the order of travel", kind="points"
    )
    speed: float = quantity(0.2, unit="m/s", doc="speed, nearly constant", minimum=1e-6)
    closed: bool = quantity(False, unit="", doc="whether the path returns to its first point")

    def relate(self) -> None:
        """The path must exist: enough points, none twice in a row, no turning on the spot."""
        waypoint_path(self)

    @property
    def cycle(self) -> float:
        """Time of one lap, or of the open path, s."""
        return waypoint_path(self).duration


@lru_cache(maxsize=64)
def waypoint_path(reference: Waypoints) -> SplinePath:
    """Return the spline path of waypoints; the speed on it is above 0.

    Raises ScenarioError if the points do not make a path that can be driven forwards.
    """
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


def numbers(reference: Waypoints) -> Numbers:
    """Return the table of the path through the points (see ``spline_motion.path_numbers``)."""
    return path_numbers(waypoint_path(reference))


def read(values: Raw) -> Raw:
    """Return a raw table with the points of its CSV file, ``reference.file``, in place of it."""
    if "file" not in values:
        return values
    file = values.pop("file")
    if not isinstance(file, str):
        raise ScenarioError(f"reference.file = {show(file)} must be the path of a CSV file.")
    if "points" in values:
        raise ScenarioError("reference.file and reference.points exclude each other: keep one.")
    return {"points": read_points(Path(file)), **values}


KIND = ReferenceKind("waypoints", Waypoints, numbers, timed(trajectory), read)
