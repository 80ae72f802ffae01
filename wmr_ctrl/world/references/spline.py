"""Paths as tables of polynomials: quintic splines, and straight lines with rounded corners.

A spline's parameter is time.  It has four continuous derivatives, so that the desired velocities
have two.  A closed path is periodic.  At the ends of an open path the second and third derivatives
are zero, so that it continues as a straight line with the smoothness that the velocities' rates
need.  In the graph of the motion the table's numbers are parameters; only the number of segments is
part of it.

For straight lines through points, a tolerance states how far the path may cut a corner.  Each
corner is a polynomial of degree five.  Its first three control points lie on one line and its last
three on the other, evenly spaced towards the corner, so direction and curvature are continuous
where it meets the lines.  Unnecessary points are removed first (`simplified`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.signals import Signal
from wmr_ctrl.core.symbolic import ca

from .kind import Numbers, cross, speeds

Array = NDArray[np.float64]

DEGREE = 5
ROUNDS = 6
SAMPLES = 64
"""Samples on each segment that find its orientation; even, so that one is in the middle."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)
TERMS = DEGREE + 1


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

    The first parameter is the chord length.  Replacing it by the arc length of the previous spline
    makes the speed more even, unless points are far apart in a bend.  The replacement is repeated
    only as long as it helps.
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
    return _directed(knots, table, closed)


def _directed(knots: Array, table: Array, closed: bool) -> SplinePath:
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


def path_numbers(path: SplinePath) -> Numbers:
    """Return the table of a path of n segments.

    Times of the knots (n+1) [s]; coefficients of x and of y (6n) [m], segment by segment in
    ascending powers of the segment's own parameter in [0, 1]; theta_d in mid-segment (n) [rad];
    growth of theta_d over a lap [rad]; 1 if laps repeat, 0 if the path ends in a straight line.
    """
    n = len(path.headings)
    x, y = (tuple(path.coefficients[..., axis].ravel().tolist()) for axis in (0, 1))
    return (
        (_signal("ref_knots", "s", "times at the knots", n + 1), tuple(path.knots.tolist())),
        (_signal("ref_x", "m", "coefficients of x_d", TERMS * n), x),
        (_signal("ref_y", "m", "coefficients of y_d", TERMS * n), y),
        (_signal("ref_theta", "rad", "theta_d in mid-segment", n), tuple(path.headings.tolist())),
        (_signal("ref_turn", "rad", "growth of theta_d over a lap", 1), (path.turn,)),
        (
            _signal("ref_laps", "1", "1: laps repeat, 0: straight on at the end", 1),
            (float(path.closed),),
        ),
    )


def _signal(name: str, unit: str, meaning: str, size: int) -> Signal:
    return Signal(name, unit, f"{meaning} of the desired path", size)


def trajectory(t: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Return the reference (7, 1) at time ``t`` [s], in the order of ``signals.REFERENCE``.

    Past the end of an open path, where its second and third derivatives vanish, the motion goes
    on along the tangent.
    """
    knots = p["ref_knots"]
    lap = p["ref_laps"] * ca.floor(t / knots[-1])
    return on_path(t - lap * knots[-1], lap, p)


def on_path(tau: ca.SX, lap: ca.SX, p: Mapping[str, ca.SX]) -> ca.SX:
    """Position, theta_d and `speeds` (7, 1) at the path's parameter ``tau``, in lap ``lap``.

    The speeds are those of a parameter that grows by 1 a second.
    """
    inside = ca.fmin(tau, p["ref_knots"][-1])
    row = _row(inside, p)
    position, velocity, acceleration, jerk = _derivatives(inside, row)
    middle = row[4]  # theta_d is the mid-heading and the angle between it and the velocity
    forward = ca.vertcat(-ca.sin(middle), ca.cos(middle))
    swing = ca.atan2(cross(forward, velocity), ca.dot(forward, velocity))
    theta = middle + swing + lap * p["ref_turn"]
    position += (tau - inside) * velocity
    return ca.vertcat(position, theta, speeds(velocity, acceleration, jerk))


def _row(tau: ca.SX, p: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
    """Start, length, coefficients of x and y (6, 1), mid-heading of the segment at ``tau``."""
    knots = p["ref_knots"]
    n = knots.numel() - 1
    x, y = (ca.reshape(p[name], TERMS, n) for name in ("ref_x", "ref_y"))
    lengths = (knots[1:] - knots[:-1]).T
    table = ca.vertcat(knots[:-1].T, lengths, x, y, p["ref_theta"].T)
    row = table[:, 0]
    for i in range(1, n):
        row = ca.if_else(tau >= knots[i], table[:, i], row)
    return row[0], row[1], row[2 : 2 + TERMS], row[2 + TERMS : 2 + 2 * TERMS], row[-1]


def _derivatives(tau: ca.SX, row: tuple[ca.SX, ...]) -> list[ca.SX]:
    """Position and its first three derivatives by time, each (2, 1)."""
    start, length, *coefficients = row[:4]
    s = (tau - start) / length
    rates = []
    for order in range(4):
        rates.append(ca.vertcat(*(ca.polyval(c[::-1], s) for c in coefficients)) / length**order)
        coefficients = [c[1:] * ca.DM(range(1, c.numel())) for c in coefficients]
    return rates


SHARES = (1.0, 0.6, 0.2)
"""Distances of the control points from the corner, as shares of the side that it takes."""
_BINOMIALS = (1.0, 5.0, 10.0)
CUT = 2 * sum(w * s for w, s in zip(_BINOMIALS, SHARES, strict=True)) / 2**DEGREE
"""Distance of the corner's middle from the corner, over the side times sin(turn/2)."""
EVEN = DEGREE * (SHARES[0] - SHARES[1])
"""Rate at a corner's ends by its own parameter, over the side: that of a line there."""
SHORTEST = 1e-9
"""Straight pieces shorter than this [m] are left out."""


def rounded(points: Array, tolerance: float, closed: bool) -> SplinePath:
    """The path through ``points`` (n, 2) [m] that cuts no corner by more than ``tolerance`` [m].

    Its parameter is the length on the lines, and continues evenly into each corner.  A closed path
    begins behind its first corner.
    """
    ring = np.vstack([points, points[:1]]) if closed else points
    steps = np.diff(ring, axis=0)
    lengths = np.hypot(*steps.T)
    ways = steps / lengths[:, None]
    sides = _sides(ways, lengths, tolerance, closed)
    pieces: list[Array] = []
    spans: list[float] = []
    for k, way in enumerate(ways):
        begin, end = ring[k] + sides[k] * way, ring[k + 1] - sides[k + 1] * way
        if lengths[k] - sides[k] - sides[k + 1] > SHORTEST:
            straight = np.zeros((DEGREE + 1, 2))
            straight[0], straight[1] = begin, end - begin
            pieces.append(straight)
            spans.append(lengths[k] - sides[k] - sides[k + 1])
        if sides[k + 1] > 0:
            pieces.append(_corner(ring[k + 1], way, ways[(k + 1) % len(ways)], sides[k + 1]))
            spans.append(EVEN * sides[k + 1])
    return _directed(sums(np.array(spans)), np.stack(pieces), closed)


def simplified(points: Array, within: float, closed: bool) -> Array:
    """Ramer-Douglas-Peucker simplification of ``points`` (n, 2) [m].

    Straight lines through the remaining points stay within that distance [m] of the lines through
    all points, compared at equal progress.  So no omitted part goes back by more than that.
    """
    ring = np.vstack([points, points[:1]]) if closed else points
    corners = {0, len(ring) - 1}
    open_pieces = [(0, len(ring) - 1)]
    while open_pieces:
        first, last = open_pieces.pop()
        if last - first > 1:
            off = _missed(ring[first : last + 1])
            middle = first + 1 + int(np.argmax(off))
            if off.max() > within:
                corners.add(middle)
                open_pieces += [(first, middle), (middle, last)]
    return ring[sorted(corners)[: -1 if closed else None]]


def _missed(points: Array) -> Array:
    """Distance of each inner point from the line between the ends, or how far it goes back [m]."""
    way, away = points[-1] - points[0], points - points[0]
    length = float(np.hypot(*way))
    direction = way / length if length > 0 else np.zeros(2)
    along = away @ direction
    off = np.hypot(*(away - np.outer(np.clip(along, 0, length), direction)).T)
    return np.maximum(off, np.maximum.accumulate(along) - along)[1:-1]


def _sides(ways: Array, lengths: Array, tolerance: float, closed: bool) -> Array:
    """Length that each point's corner takes from both lines [m], (n + 1,); 0 without corner."""
    before, after = (np.roll(ways, 1, axis=0), ways)
    cosines = np.clip(np.einsum("ij,ij->i", before, after), -1, 1)
    halves = np.sqrt((1 - cosines) / 2)  # sin(turn/2)
    room = np.minimum(np.roll(lengths, 1), lengths) / 2
    with np.errstate(divide="ignore"):
        sides = np.where(halves > 1e-9, np.minimum(tolerance / (CUT * halves), room), 0.0)
    if not closed:
        sides[0] = 0.0
    return np.append(sides, sides[0] if closed else 0.0)


def _corner(corner: Array, before: Array, after: Array, side: float) -> Array:
    """Coefficients (6, 2) of a corner, from its control points."""
    control = np.array(
        [corner - side * s * before for s in SHARES]
        + [corner + side * s * after for s in reversed(SHARES)]
    )
    rows = (
        sum((-1) ** (p - j) * math.comb(p, j) * control[j] for j in range(p + 1))
        for p in range(DEGREE + 1)
    )
    return np.array([math.comb(DEGREE, p) * row for p, row in enumerate(rows)])
