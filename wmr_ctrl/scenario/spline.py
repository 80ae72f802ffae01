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
    """Return the spline path through ``points`` (n, 2) [m] at about ``speed`` [m/s].

    The parameter starts as the chord length; a few rounds replace it by the arc length of the
    spline found so far, which brings the mean speed of every segment to ``speed``.
    """
    if closed:
        points = np.vstack([points, points[:1]])
    lengths = np.hypot(*np.diff(points, axis=0).T)
    for _ in range(ROUNDS):
        table = _polynomials(_sums(lengths), points, closed)
        lengths = _arc_lengths(table)
    knots = _sums(lengths / speed)
    table = _polynomials(knots, points, closed)
    headings, turn = _headings(table)
    return SplinePath(knots, table, headings, turn if closed else 0.0, closed)


def _sums(steps: Array) -> Array:
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


def _arc_lengths(table: Array) -> Array:
    """Length of every segment by Gauss quadrature, (n,) [m]."""
    velocity = _evaluate(table, 1, (_NODES + 1) / 2)
    return np.asarray(np.hypot(velocity[..., 0], velocity[..., 1]) @ _WEIGHTS / 2)


def _headings(table: Array) -> tuple[Array, float]:
    """Unwrapped theta_d at mid-segments (n,) and its growth over the whole path [rad].

    The direction is followed from sample to sample, 32 in every segment, so that a turn of more
    than half a circle within one segment keeps its sense.
    """
    count = 32
    velocity = _evaluate(table, 1, np.arange(count + 1) / count)
    psi = np.arctan2(velocity[..., 1], velocity[..., 0])
    theta = np.unwrap(np.concatenate([psi[:, :-1].ravel(), psi[-1:, -1]])) - math.pi / 2
    theta -= 2 * math.pi * math.ceil((theta[0] - math.pi) / (2 * math.pi))
    turn = round(float(theta[-1] - theta[0]) / (2 * math.pi)) * 2 * math.pi
    return theta[:-1].reshape(-1, count)[:, count // 2], turn
