"""Quintic spline through points, as a table of polynomials in a parameter that is time.

The spline has four continuous derivatives, so that the desired velocities have two.  A closed
path is periodic.  At the ends of an open path the second and third derivatives are zero, so that
it goes over into a straight line as smoothly as the velocities' rates need.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREE = 5
ROUNDS = 6
SAMPLES = 64
"""Samples on each segment that find its orientation; even, so that one is in the middle."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True, eq=False)
class SplinePath:
    """A path of n polynomial segments, followed in time.

    ``knots`` (n+1,) [s] start at 0.  ``coefficients`` (n, 6, 2) [m] are those of x and y in
    ascending powers of s = (t - knots[i])/(knots[i+1] - knots[i]).  ``headings`` (n,) [rad] are
    theta_d in the middle of each segment, unwrapped along the path.  ``turn`` [rad] is how much
    theta_d grows over a lap of a closed path.
    """

    knots: Array
    coefficients: Array
    headings: Array
    turn: float
    closed: bool

    @property
    def duration(self) -> float:
        """Time from the first point to the last (of a closed path: the lap), s."""
        return float(self.knots[-1])

    def derivatives(self, order: int, s: Array) -> Array:
        """Derivative of position by time at local parameters ``s`` (k,): (n, k, 2) [m/s^order]."""
        lengths = np.diff(self.knots)[:, None, None]
        return _evaluate(self.coefficients, order, s) / lengths**order


def fit(points: Array, speed: float, closed: bool) -> SplinePath:
    """Return the spline path through ``points`` (n, 2) [m] at the mean speed ``speed`` [m/s].

    The parameter is the chord length at first.  Taking the arc length of the spline found so far
    instead makes the speed more even where the points are; where they are far apart in a bend it
    would not, so that each round is kept only as long as it helps.
    """
    if closed:
        points = np.vstack([points, points[:1]])
    steps = np.hypot(*np.diff(points, axis=0).T)
    table = _polynomials(sums(steps), points, closed)
    for _ in range(ROUNDS):
        longer = arc_lengths(table)
        trial = _polynomials(sums(longer), points, closed)
        if not _unevenness(trial, longer) < 0.999 * _unevenness(table, steps):
            break
        steps, table = longer, trial
    knots = sums(steps) * (arc_lengths(table).sum() / steps.sum() / speed)
    theta = headings(table)
    turns = round(float(theta[-1, -1] - theta[0, 0]) / (2 * math.pi)) if closed else 0
    return SplinePath(knots, table, theta[:, SAMPLES // 2], 2 * math.pi * turns, closed)


def _unevenness(table: Array, steps: Array) -> float:
    """Ratio of the largest to the smallest speed, with ``steps`` as the segments' durations."""
    velocity = _evaluate(table, 1, np.linspace(0, 1, 17)) / steps[:, None, None]
    speeds = np.hypot(velocity[..., 0], velocity[..., 1])
    return float(speeds.max() / max(speeds.min(), 1e-12 * speeds.max()))


def sums(steps: Array) -> Array:
    """Return the places of knots from the steps between them; the first is 0."""
    return np.concatenate([[0.0], np.cumsum(steps)])


def _polynomials(knots: Array, points: Array, closed: bool) -> Array:
    """Coefficients (n, 6, 2) of the interpolating spline, ascending, in local parameters."""
    from scipy.interpolate import make_interp_spline  # slow to import, and seldom needed

    flat = [(2, np.zeros(2)), (3, np.zeros(2))]
    ends: Any = "periodic" if closed else (flat, flat)
    spline = make_interp_spline(knots, points, k=DEGREE, bc_type=ends)
    lengths = np.diff(knots)[:, None]
    terms = [
        spline(knots[:-1], nu=power) * lengths**power / math.factorial(power)
        for power in range(DEGREE + 1)
    ]
    return np.stack(terms, axis=1)


def _evaluate(table: Array, order: int, s: Array) -> Array:
    """Derivative by the local parameter, at ``s`` (k,), of every segment: (n, k, 2)."""
    powers = np.arange(order, DEGREE + 1)
    factors = np.array([math.perm(int(p), order) for p in powers], dtype=float)
    basis = s[:, None] ** (powers - order) * factors
    return np.asarray(np.einsum("kp,npc->nkc", basis, table[:, order:, :]))


def arc_lengths(table: Array) -> Array:
    """Length of every segment by Gauss quadrature, (n,) [m]."""
    velocity = _evaluate(table, 1, (_NODES + 1) / 2)
    return np.asarray(np.hypot(velocity[..., 0], velocity[..., 1]) @ _WEIGHTS / 2)


def headings(table: Array) -> Array:
    """Theta_d [rad] along each segment, (n, SAMPLES + 1), continuous over the whole path.

    The direction is followed from sample to sample, so that a turn of more than half a circle
    within a segment keeps its sense.  The first value lies in (-pi, pi].
    """
    velocity = _evaluate(table, 1, np.arange(SAMPLES + 1) / SAMPLES)
    psi = np.arctan2(velocity[..., 1], velocity[..., 0])
    theta = np.unwrap(psi.ravel()) - math.pi / 2
    theta -= 2 * math.pi * math.ceil((theta[0] - math.pi) / (2 * math.pi))
    return theta.reshape(-1, SAMPLES + 1)
