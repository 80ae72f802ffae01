"""Motion along a table of polynomial segments, as rounded squares and waypoints have it.

The table's numbers are parameters of the graph; only the number of segments is part of it.
"""

from __future__ import annotations

from collections.abc import Mapping

from wmr_ctrl.signals import Signal
from wmr_ctrl.symbolic import ca
from wmr_ctrl.world.references.kind import Numbers, cross, speeds
from wmr_ctrl.world.references.spline import DEGREE, SplinePath

TERMS = DEGREE + 1


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
    theta = _heading(row[4], velocity) + lap * p["ref_turn"]
    position += (tau - inside) * velocity
    return ca.vertcat(position, theta, speeds(velocity, acceleration, jerk))


def _row(tau: ca.SX, p: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
    """Start, length, coefficients of x and y (6, 1), mid-heading of the segment at ``tau``."""
    knots = p["ref_knots"]
    n = knots.numel() - 1
    table = ca.vertcat(
        knots[:-1].T,
        (knots[1:] - knots[:-1]).T,
        ca.reshape(p["ref_x"], TERMS, n),
        ca.reshape(p["ref_y"], TERMS, n),
        p["ref_theta"].T,
    )
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
        rates.append(ca.vertcat(*(_horner(c, s) for c in coefficients)) / length**order)
        coefficients = [c[1:] * ca.DM(range(1, c.numel())) for c in coefficients]
    return rates


def _horner(coefficients: ca.SX, s: ca.SX) -> ca.SX:
    value = coefficients[-1]
    for i in reversed(range(coefficients.numel() - 1)):
        value = value * s + coefficients[i]
    return value


def _heading(middle: ca.SX, velocity: ca.SX) -> ca.SX:
    """theta_d from the segment's mid-heading and the angle between it and the velocity."""
    forward = ca.vertcat(-ca.sin(middle), ca.cos(middle))
    return middle + ca.atan2(cross(forward, velocity), ca.dot(forward, velocity))
