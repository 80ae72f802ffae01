"""What every kind of reference shares: types, and velocities from a path's derivatives."""

from __future__ import annotations

from typing import TypeAlias

import casadi as ca

from wmr_ctrl.signals import Signal

Parameters: TypeAlias = tuple[tuple[Signal, tuple[float, ...]], ...]
"""Signals of a reference's parameters, each with its values."""


def speeds(velocity: ca.SX, acceleration: ca.SX, jerk: ca.SX) -> ca.SX:
    """Return v1_d, v2_d, v1_d_dot, v2_d_dot (4, 1) of a robot that drives forwards on a path.

    ``velocity``, ``acceleration`` and ``jerk`` are the path's derivatives (2, 1), in m/s, m/s2
    and m/s3; the velocity must not vanish.  The rates follow from v1^2 = p'.p' and
    v1^2 v2 = p' x p'', both differentiated once.
    """
    square = ca.dot(velocity, velocity)
    along = ca.dot(velocity, acceleration)
    v1 = ca.sqrt(square)
    v2 = cross(velocity, acceleration) / square
    v2_dot = (cross(velocity, jerk) - 2 * v2 * along) / square
    return ca.vertcat(v1, v2, along / v1, v2_dot)


def cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """Return the third component of the cross product of two plane vectors."""
    return a[0] * b[1] - a[1] * b[0]
