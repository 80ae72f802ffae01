"""Square with smoothed corners, a closed spline path: the curvature grows and falls like sin^2."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.core.fields.unstated import derived

from .kind import Numbers, Pair, Reference, ReferenceKind, driven, timed
from .spline import Array, SplinePath, fit, path_numbers, trajectory

CORNER_STEPS = 6
SIDE, CORNER_TURNS = 3.75, 2.0
"""Side over corner of a square that nobody sizes; turning in a corner, times corner over speed."""
GROWTH = 2.5
"""Ratio of neighbouring steps along a side, away from a corner: ripples die out in them."""


class RoundedSquare(Reference):
    """Square with smoothed corners, counter-clockwise from the middle of its lower side.

    Omitted fields are derived: the speed is half its limit, turning at most a quarter of its own.
    """

    side: float = quantity(derived(3.0), "m", "side of the square", minimum=1e-6)
    corner: float = quantity(
        derived(0.8),
        "m",
        "length of side that a corner takes at each end; at most side/2",
        minimum=1e-6,
    )
    speed: float = quantity(derived(0.1), "m/s", "speed, nearly constant", minimum=1e-6)

    def sized(self, limits: Pair, accel: Pair) -> Mapping[str, float]:
        """Speed, corners and side of a square that the robot can follow."""
        speed, turning = driven(limits)
        corner, side = self.stated("corner"), self.stated("side")
        if corner or side:
            corner = corner or (side or 0.0) / SIDE
            speed = min(speed, turning * corner / CORNER_TURNS)
        else:
            corner = CORNER_TURNS * (self.stated("speed") or speed) / turning
        return {"speed": speed, "corner": corner, "side": SIDE * corner}

    def relate(self) -> None:
        """Check that two corners fit on a side."""
        known = self.stated("corner") and self.stated("side")
        if known and self.corner > self.side / 2:
            raise ScenarioError(
                f"reference.corner = {self.corner!r} must be at most half of reference.side = "
                f"{self.side!r} m: two corners share a side. Lower corner or raise side."
            )

    @property
    def cycle(self) -> float:
        """Time of one lap, s."""
        return square_path(self).duration


@lru_cache(maxsize=64)
def square_path(reference: RoundedSquare) -> SplinePath:
    """Return the spline path of a rounded square."""
    return fit(square_points(reference.side, reference.corner), reference.speed, True)


def numbers(reference: RoundedSquare) -> Numbers:
    """Return the table of the square's path (see `path_numbers`)."""
    return path_numbers(square_path(reference))


def square_points(side: float, corner: float) -> Array:
    """Points (n, 2) [m], counter-clockwise from the middle of the lower side at the origin."""
    turn = _corner(corner)
    straight = side - 2 * corner
    step = float(np.hypot(*(turn[1] - turn[0])))
    half = straight / 2
    graded = _graded(half, step)
    run_up = np.column_stack([half - graded, np.zeros_like(graded)])[:-1]
    run_out = np.column_stack([np.full_like(graded, side / 2), corner + graded[::-1]])[:-1]
    middle = turn + np.array([straight / 2, 0.0])
    first = np.vstack([run_up, middle[:-1], run_out]) if straight > 0 else middle[:-1]
    centre, right_angle = np.array([0.0, side / 2]), np.array([[0.0, -1.0], [1.0, 0.0]])
    turns = (np.linalg.matrix_power(right_angle, quarter).T for quarter in range(4))
    return np.vstack([(first - centre) @ turn + centre for turn in turns])


def _corner(corner: float) -> Array:
    """Points (CORNER_STEPS + 1, 2) of one corner from (0, 0), heading +X, to (corner, corner)."""
    fine = 200
    sigma = np.linspace(0, 1, fine * CORNER_STEPS + 1)
    middles = (sigma[:-1] + sigma[1:]) / 2
    heading = np.pi / 2 * (middles - np.sin(2 * np.pi * middles) / (2 * np.pi))
    steps = np.column_stack([np.cos(heading), np.sin(heading)])
    path = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])[::fine]
    return np.asarray(path * (corner / path[-1]))


def _graded(length: float, step: float) -> Array:
    """Distances from a corner along half a side, from ``length`` to 0, with growing steps."""
    distances = [0.0]
    while distances[-1] + step < 0.7 * length:
        distances.append(distances[-1] + step)
        step *= GROWTH
    return np.array([*distances, length])[::-1]


KIND = ReferenceKind("rounded-square", RoundedSquare, timed(trajectory), numbers)
