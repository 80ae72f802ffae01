"""Free distances of a round body, ahead and behind, while its heading stays within a window.

The body is a disc about the axle's midpoint, whose heading stays within ``right`` and ``left`` of
the present one.  It may cover a sector and the disc around it (a cone).  For a point at distance p
and bearing b, with o the part of b outside the window,

    way = p cos o - sqrt(R^2 - p^2 sin^2 o)        where p |sin o| <= R and |o| < 90 degrees,

and no limit elsewhere.  Behind the robot, bearings are measured from its back.  A wall is met at
one of its ends, or along the heading of the window nearest to its normal.
"""

from collections.abc import Sequence
from functools import reduce

import casadi as ca

from wmr_ctrl.core.fields.values import Pair
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.results.obstacles import Shape

Point = tuple[ca.SX, ca.SX]
WIDEST = 1.5
"""Widest window to either side [rad]; a cone of more than 90 degrees to a side is a disc."""


def way_to_point(
    place: Point, window: tuple[ca.SX, ca.SX], radius: ca.SX | float, sense: int
) -> ca.SX:
    """Distance [m] to a point ``place`` (ahead, to the left) [m] for a disc of ``radius`` [m].

    ``window``: heading to the left and to the right [rad]; ``sense``: 1 ahead, -1 backwards.
    Negative if the disc covers the point already; `LARGEST` if it never does.
    """
    along, across = sense * place[0], sense * place[1]
    outside = _outside(ca.atan2(across, along), window)
    on, off = along * along + across * across, ca.sin(outside)
    squared = radius * radius - on * off * off
    meets = ca.logic_and(squared >= 0, ca.cos(outside) > 0)
    way = ca.sqrt(on) * ca.cos(outside) - ca.sqrt(ca.fmax(squared, 0))
    return ca.if_else(meets, way, LARGEST)


def way_to_wall(
    ends: tuple[Point, Point], window: tuple[ca.SX, ca.SX], radius: ca.SX | float, sense: int
) -> ca.SX:
    """Distance [m] to a straight wall between two points; see `way_to_point`."""
    (ax, ay), (bx, by) = [[sense * part for part in end] for end in ends]
    tx, ty = bx - ax, by - ay
    length = ca.sqrt(tx * tx + ty * ty)
    share = -(ax * tx + ay * ty) / (length * length)  # of the nearest point of its line
    px, py = ax + share * tx, ay + share * ty
    outside = _outside(ca.atan2(py, px), window)
    way = (ca.sqrt(px * px + py * py) - radius) / ca.cos(outside)
    met = share - ca.sign(ax * by - ay * bx) * way * ca.sin(outside) / length
    inner = reduce(ca.logic_and, (ca.cos(outside) > 0, met >= 0, met <= 1))
    points = (way_to_point(end, window, radius, sense) for end in ends)
    return reduce(ca.fmin, points, ca.if_else(inner, way, LARGEST))


def _outside(bearing: ca.SX, window: tuple[ca.SX, ca.SX]) -> ca.SX:
    """Signed angle [rad] by which a bearing is outside a window."""
    return bearing - ca.fmax(-window[1], ca.fmin(window[0], bearing))


def seen_from(pose: ca.SX, place: Pair) -> Point:
    """A point (X, Y) [m] relative to a pose (3,): ahead, to the left [m]."""
    x, y = place[0] - pose[0], place[1] - pose[1]
    s, c = ca.sin(pose[2]), ca.cos(pose[2])
    return c * y - s * x, -(c * x + s * y)


def free_distances(
    shapes: Sequence[Shape], pose: ca.SX, window: tuple[ca.SX, ca.SX], radius: ca.SX | float
) -> tuple[ca.SX, ca.SX]:
    """Distances [m] that a disc at ``pose`` (3,) can move ahead and back before it touches a
    shape.
    """
    ways = []
    for sense in (1, -1):
        own = [ca.SX(LARGEST)]
        for shape in shapes:
            if isinstance(shape[0], tuple):
                ends = [seen_from(pose, corner) for corner in shape]
                walls = zip(ends, [*ends[1:], ends[0]], strict=True)
                own += [way_to_wall(wall, window, radius, sense) for wall in walls]
            else:
                x, y, size = shape
                own.append(way_to_point(seen_from(pose, (x, y)), window, radius + size, sense))
        ways.append(reduce(ca.fmin, own))
    return ways[0], ways[1]
