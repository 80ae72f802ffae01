"""Path through given points, driven as fast as stated limits admit, with a rest at its end.

``file = "way.csv"`` may replace ``points``: x,y, a point a row, in m or in the unit that its header
states, such as ``x [mm]``; semicolons or tabs may separate columns.  ``"way.yaml"`` is a path
message: ``poses`` with ``position``.  The smooth path through the points has four continuous
derivatives.  With ``tolerance`` the path is straight lines with rounded corners; if there are more
than MOST_POINTS points, those that half of the tolerance does not need are omitted.  At the
beginning and at the end v1_d is 0, and the theorems of the paper, which require v1_d > 0, do not
apply there.  The laws stay defined, and a run shows whether the robot arrives.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np

from wmr_ctrl.core.errors import ScenarioError, show
from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.core.fields.unstated import derived
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

from . import spline
from .kind import Numbers, Pair, Raw, Reference, ReferenceKind, timed
from .point_files import SAME, read_points
from .speed_profile import PathLimits, SpeedProfile, fastest

MOST_POINTS = 400
SLOWEST = 0.1
"""Smallest share of its mean rate that a path may fall to: below it turns on the spot."""
SHARPEST = math.pi / 4
"""Largest turn, rad, between two of the samples on a segment."""
WIDEST = 3.0
"""Largest turn, rad, from the middle of a segment to either end."""
EXAMPLE = """\
[reference]
kind = "waypoints"
points = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.5], [4.0, 1.5]]
# or, in place of points: file = "way.csv" (rows x,y in m) or "way.yaml" (poses with position)
speed = 0.3
tolerance = 0.2
at_end = "stop"
"""
RISE = 2.5
"""Time in which a path that nobody sizes reaches its speeds [s]."""
STOP, CONTINUE, LOOP = "stop", "continue", "loop"
_ROWS = (
    ("ref_start", "s", "times at which the speed's rows begin"),
    ("ref_place", "m", "way at the start of each row"),
    ("ref_rate", "m/s", "rate of the way at the start of each row"),
    ("ref_acceleration", "m/s2", "its constant rate in each row"),
)


class Waypoints(Reference):
    """Path through given points, as fast as its limits admit, and a rest at its end.

    With ``at_end = "stop"`` the desired motion begins and ends at rest; with ``"continue"`` it
    begins at speed and goes straight on past the end; with ``"loop"`` the path is closed and
    repeated.  A closed path returns from the last point to the first.  Omitted speeds are half of
    their limits, reached within 2.5 s or as fast as the base's own ramps admit.
    """

    points: tuple[tuple[float, float], ...] = quantity(
        (),
        "m",
        f"x, y of each point, in the order of travel; more than {MOST_POINTS} need tolerance",
        kind="points",
    )
    speed: float = quantity(derived(0.1), "m/s", "speed wherever no limit is lower", minimum=1e-6)
    v_max: float | None = quantity(None, "m/s", "largest v1_d, instead of speed", minimum=1e-6)
    omega_max: float = quantity(derived(0.1), "rad/s", "largest |v2_d|", minimum=1e-6)
    a_max: float = quantity(derived(0.1), "m/s2", "largest rate of v1_d", minimum=1e-6)
    alpha_max: float = quantity(derived(0.1), "rad/s2", "largest rate of v2_d", minimum=1e-6)
    tolerance: float | None = quantity(
        None,
        "m",
        "how far a corner may be cut; left out: a smooth path through all points",
        minimum=1e-6,
        usual=(0, 5),
    )
    at_end: str = quantity(STOP, "1", "what follows the last point", options=(STOP, CONTINUE, LOOP))
    closed: bool = quantity(False, "1", "whether the path returns to its first point")

    def sized(self, limits: Pair, accel: Pair) -> Mapping[str, float]:
        """Speeds and their rates that leave a margin to the limits."""
        speed, turning = (0.5 * limit for limit in limits)
        rates = (min(v / RISE, a) for v, a in zip((speed, turning), accel, strict=True))
        own = dict(zip(("a_max", "alpha_max"), rates, strict=True))
        return {"speed": speed, "omega_max": turning, **own}

    def relate(self) -> None:
        """Check that the path exists: enough points, none repeated, no turning on the spot."""
        profile_of(self)

    @property
    def returns(self) -> bool:
        """True where the path leads back to its first point."""
        return self.closed or self.at_end == LOOP

    @property
    def cycle(self) -> float:
        """Time of one lap, or of the open path [s]."""
        return profile_of(self).duration

    @property
    def arrival(self) -> float | None:
        """Time at which the desired motion comes to rest at the path's end [s]; None: never."""
        return profile_of(self).duration if self.at_end == STOP else None


@lru_cache(maxsize=64)
def waypoint_path(reference: Waypoints) -> spline.SplinePath:
    """Return the path of waypoints, with nearly its length as the parameter.

    Raises ScenarioError if the points do not make a path that can be driven forwards.
    """
    given, closed, tolerance = _checked_points(reference), reference.returns, reference.tolerance
    points = given
    if tolerance is not None and len(given) > MOST_POINTS:
        tolerance /= 2
        points = _thinned(given, tolerance, closed)
    try:
        if tolerance is None:
            path = spline.fit(points, 1.0, closed)
        else:
            path = spline.rounded(points, tolerance, closed)
    except (ValueError, np.linalg.LinAlgError) as problem:
        raise ScenarioError(
            f"reference.points: no smooth path runs through them ({problem}). "
            "Space them more evenly."
        ) from None
    _check_forward(path, given)
    return path


@lru_cache(maxsize=64)
def profile_of(reference: Waypoints) -> SpeedProfile:
    """Return the path's parameter as a function of time.

    Raises ScenarioError as `waypoint_path` does.
    """
    limits = PathLimits(
        speed=reference.speed if reference.v_max is None else reference.v_max,
        turning=reference.omega_max,
        acceleration=reference.a_max,
        angular_acceleration=reference.alpha_max,
    )
    path, stop = waypoint_path(reference), reference.at_end == STOP
    try:
        return fastest(path, limits, stop, stop)
    except ValueError as problem:
        raise ScenarioError(
            f"reference.points: the path cannot be driven ({problem}). Raise reference.omega_max "
            "or reference.alpha_max, or round the path more."
        ) from None


def _checked_points(reference: Waypoints) -> spline.Array:
    points, closed = list(reference.points), reference.returns
    if closed and len(points) > 1 and math.dist(points[0], points[-1]) < SAME:
        points.pop()
    _check_count(len(points), closed, reference.tolerance)
    for i in range(1, len(points)):
        if math.dist(points[i - 1], points[i]) < SAME:
            raise ScenarioError(
                f"reference.points[{i}] and reference.points[{i + 1}] are the same point "
                f"{points[i]}: the path has no direction there. Remove one of them."
            )
    return np.array(points, dtype=float)


def _thinned(points: spline.Array, within: float, closed: bool) -> spline.Array:
    """The points that a path within the distance ``within`` [m] of all points needs."""
    left = spline.simplified(points, within, closed)
    if _least(closed) <= len(left) <= MOST_POINTS:
        return left
    change = "Raise" if len(left) > MOST_POINTS else "Lower"
    raise ScenarioError(
        f"reference.tolerance = {2 * within:g} m: of the {len(points)} points of the path "
        f"{len(left)} are needed to stay within half of it, and {_least(closed)} to {MOST_POINTS} "
        f"are possible. {change} reference.tolerance."
    )


def _least(closed: bool) -> int:
    return 3 if closed else 2


def _check_count(count: int, closed: bool, tolerance: float | None) -> None:
    shape = "a closed path" if closed else "a path"
    if count < _least(closed):
        raise ScenarioError(
            f"reference.points has {count} different point(s), but {shape} needs at least "
            f"{_least(closed)}. Add points, as x, y in m, or name a file of them in "
            "reference.file; `wmr-ctrl scenarios --reference waypoints` shows an example."
        )
    if count > MOST_POINTS and tolerance is None:
        raise ScenarioError(
            f"reference.points has {count} points; a path through all can have at most "
            f"{MOST_POINTS}. Say how far the path may miss them, such as "
            "reference.tolerance = 0.05 in m: those that it does not need are then left out."
        )


def _check_forward(path: spline.SplinePath, points: spline.Array) -> None:
    """Refuse a path that nearly stops to turn, since the branch of theta_d would be ambiguous."""
    velocity = path.derivatives(1, np.linspace(0, 1, spline.SAMPLES + 1))
    share = np.hypot(velocity[..., 0], velocity[..., 1])
    theta = spline.headings(path.coefficients)
    steps = np.abs(np.diff(theta, axis=1)).max(axis=1)
    reach = np.abs(theta - path.headings[:, None]).max(axis=1)
    good = (share.min(axis=1) >= SLOWEST) & (steps <= SHARPEST) & (reach <= WIDEST)
    if not good.all():
        segment = int(np.argmin(good))
        sample = int(np.argmin(share[segment]))
        place = path.derivatives(0, np.array([sample / spline.SAMPLES]))[segment, 0]
        point = int(np.argmin(np.hypot(*(points - place).T))) + 1
        raise ScenarioError(
            f"reference.points[{point}]: the path turns almost on the spot near this point, which "
            "a robot that drives forwards cannot follow. Add points that round the turn."
        )


def numbers(reference: Waypoints) -> Numbers:
    """Return the table of the path (see `path_numbers`) and of its speed."""
    profile = profile_of(reference)
    table = spline.path_numbers(waypoint_path(reference))
    path = [(s, v) for s, v in table if s.name != "ref_laps"]
    columns = profile.starts, profile.places, profile.rates, profile.accelerations
    rows = [
        (Signal(name, unit, f"{meaning} of the desired path", len(values)), tuple(values.tolist()))
        for (name, unit, meaning), values in zip(_ROWS, columns, strict=True)
    ]
    laps = Signal("ref_laps", "1", "1: laps of the desired path repeat, 0: they do not")
    return (*path, *rows, (laps, (float(reference.at_end == LOOP),)))


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``.

    The path's parameter s has constant acceleration in each row of the table, so that
    v1_d = |p'| s_t and v2_d = k s_t with p' and k of the path alone: defined at rest too.
    """
    starts = p["ref_start"]
    lap = p["ref_laps"] * ca.floor(t / starts[-1])
    tau = t - lap * starts[-1]
    table = ca.horzcat(starts, p["ref_place"], p["ref_rate"], p["ref_acceleration"])
    row = _row_at(tau, table)
    late, acceleration = tau - row[0], row[3]
    place = row[1] + late * (row[2] + late * acceleration / 2)
    rate = ca.fmax(row[2] + late * acceleration, 0)
    there = spline.on_path(place, lap, p)
    speeds, slopes = there[3:5], there[5:7]
    return ca.vertcat(there[:3], speeds * rate, slopes * rate**2 + speeds * acceleration)


def _row_at(tau: ca.SX, table: ca.SX) -> ca.SX:
    """The last row that begins at or before ``tau``, else the first, by bisection."""
    if table.size1() == 1:
        return table
    half = table.size1() // 2
    return ca.if_else(
        tau >= table[half, 0], _row_at(tau, table[half:, :]), _row_at(tau, table[:half, :])
    )


def read(values: Raw) -> Raw:
    """Return a raw table with the points of the file ``reference.file`` in place of its name."""
    if "file" not in values:
        return values
    file = values.pop("file")
    if not isinstance(file, str):
        raise ScenarioError(
            f"reference.file = {show(file)} must be the path of a CSV or YAML file."
        )
    if "points" in values:
        raise ScenarioError("reference.file and reference.points exclude each other: keep one.")
    return {"points": read_points(Path(file)), **values}


KIND = ReferenceKind("waypoints", Waypoints, timed(trajectory), numbers, read, EXAMPLE)
