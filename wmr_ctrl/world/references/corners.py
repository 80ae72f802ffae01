"""Straight lines through points with rounded corners: how far the path may cut one is stated.

Each corner is a polynomial of degree five whose first three control points lie on the one line and
whose last three on the other, evenly spaced towards the corner: direction and curvature are
continuous where it meets the lines.  Points beyond need are left out before (`simplified`).
"""

import math

import numpy as np

from wmr_ctrl.world.references.spline import DEGREE, SAMPLES, Array, SplinePath, headings, sums

SHARES = (1.0, 0.6, 0.2)
"""Distances of the control points from the corner, as shares of the side that it takes."""
_WEIGHTS = (1.0, 5.0, 10.0)
CUT = 2 * sum(w * s for w, s in zip(_WEIGHTS, SHARES, strict=True)) / 2**DEGREE
"""Distance of the corner's middle from the corner, over the side times sin(turn/2)."""
EVEN = DEGREE * (SHARES[0] - SHARES[1])
"""Rate at a corner's ends by its own parameter, over the side: that of a line there."""
SHORTEST = 1e-9
"""Straight pieces shorter than this [m] are left out."""


def rounded(points: Array, tolerance: float, closed: bool) -> SplinePath:
    """The path through ``points`` (n, 2) [m] that cuts no corner by more than ``tolerance`` [m].

    Its parameter is the length on the lines, and grows as evenly where a corner meets them.
    A closed path begins behind its first corner.
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
    table = np.stack(pieces)
    theta = headings(table)
    turns = round(float(theta[-1, -1] - theta[0, 0]) / (2 * math.pi)) if closed else 0
    return SplinePath(
        sums(np.array(spans)), table, theta[:, SAMPLES // 2], 2 * math.pi * turns, closed
    )


def simplified(points: Array, within: float, closed: bool) -> Array:
    """Ramer-Douglas-Peucker simplification of ``points`` (n, 2) [m].

    Straight lines through those that are left stay within that distance [m] of the lines through
    all, at a place that is as far along: what is left out goes back by no more than that either.
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
    """Distance of each inner point from the line between the ends, or behind one before it [m]."""
    way, away = points[-1] - points[0], points - points[0]
    length = float(np.hypot(*way))
    direction = way / length if length > 0 else np.zeros(2)
    along = away @ direction
    off = np.hypot(*(away - np.outer(np.clip(along, 0, length), direction)).T)
    return np.maximum(off, np.maximum.accumulate(along) - along)[1:-1]


def _sides(ways: Array, lengths: Array, tolerance: float, closed: bool) -> Array:
    """Length of both its lines that each point's corner takes [m], (n + 1,); 0 where none is."""
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
