"""Kinematics of the nonholonomic robot, Eqs. (3), (5), (6).

theta is measured from +Y: the robot moves along (-sin theta, cos theta).  The usual heading is
psi = theta + pi/2.
"""

from __future__ import annotations

from wmr_ctrl.symbolic import ca


def velocity_map(theta: ca.SX) -> ca.SX:
    """H(q), 3x2, Eq. (5): q' = H v with v = (v1, omega), Eq. (6) (printed transposed)."""
    return ca.vertcat(
        ca.horzcat(-ca.sin(theta), 0),
        ca.horzcat(ca.cos(theta), 0),
        ca.horzcat(0, 1),
    )


def constraint(theta: ca.SX) -> ca.SX:
    """A(q), 3x1, Eq. (3): A' q' = 0, no sideways motion (printed as A q' = 0)."""
    return ca.vertcat(ca.cos(theta), ca.sin(theta), 0)


def pose_rate(theta: ca.SX, v: ca.SX) -> ca.SX:
    """q' = H v: rates of x, y [m/s] and theta [rad/s], Eqs. (4)-(6)."""
    return ca.vertcat(-ca.sin(theta) * v[0], ca.cos(theta) * v[0], v[1])
