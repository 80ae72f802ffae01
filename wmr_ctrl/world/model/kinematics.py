"""Kinematics: Eqs. (3), (5), (6), tracking error, Eqs. (8), (33)-(35), and v_c0 of Eq. (7).

theta is measured from +Y: the robot moves along (-sin theta, cos theta).  The usual heading is
psi = theta + pi/2.
"""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.symbolic import ca


def pose_rate(theta: ca.SX, v: ca.SX) -> ca.SX:
    """q' = H v: rates of x, y [m/s] and theta [rad/s], Eqs. (4)-(6)."""
    return ca.vertcat(-ca.sin(theta) * v[0], ca.cos(theta) * v[0], v[1])


def error_rotation(theta: ca.SX) -> ca.SX:
    """The 3x3 matrix of Eq. (8): rows ahead, to the left, angle."""
    s, c = ca.sin(theta), ca.cos(theta)
    return ca.vertcat(ca.horzcat(-s, c, 0), ca.horzcat(-c, -s, 0), ca.horzcat(0, 0, 1))


def tracking_error(pose_d: ca.SX, pose: ca.SX) -> ca.SX:
    """e = R(theta)(q_d - q), Eq. (8): e1 ahead [m], e2 to the left [m], e3 [rad]."""
    s, c = ca.sin(pose[2]), ca.cos(pose[2])
    d = pose_d - pose
    return ca.vertcat(-s * d[0] + c * d[1], -c * d[0] - s * d[1], d[2])


def error_rate(e: ca.SX, v: ca.SX, v_d: ca.SX) -> ca.SX:
    """e' of Eqs. (33)-(35), for velocity v and desired velocity v_d (m/s, rad/s)."""
    return ca.vertcat(
        e[1] * v[1] - v[0] + v_d[0] * ca.cos(e[2]),
        -e[0] * v[1] + v_d[0] * ca.sin(e[2]),
        v_d[1] - v[1],
    )


class KinematicGains(Section, key="gains.kinematics"):
    """Gains of the kinematic loop, shared by all laws (k_1, k_2, k_3 > 0, k_2 >= 1)."""

    k: tuple[float, float, float] = quantity(
        (10.0, 5.0, 4.0), "1/s, 1/m2, 1/s", "k_1, k_2, k_3 of Eq. (7), paper Section V", above=0.0
    )


def auxiliary_velocity(e: ca.SX, v_d: ca.SX, k: ca.SX) -> ca.SX:
    """v_c0 of Eq. (7): (v1_d cos e3 + k1 e1, v2_d + k2 v1_d e2 + k3 sin e3) [m/s, rad/s]."""
    return ca.vertcat(
        v_d[0] * ca.cos(e[2]) + k[0] * e[0], v_d[1] + k[1] * v_d[0] * e[1] + k[2] * ca.sin(e[2])
    )


def auxiliary_rate(e: ca.SX, v: ca.SX, v_d: ca.SX, v_d_dot: ca.SX, k: ca.SX) -> ca.SX:
    """v_c0' by the chain rule through Eqs. (7), (33)-(35): exact for measured v and given v_d'."""
    return _rate_along(error_rate(e, v, v_d), e, v_d, v_d_dot, k)


def reference_rate(e: ca.SX, v_d: ca.SX, v_d_dot: ca.SX, k: ca.SX) -> ca.SX:
    """Part of v_c0' due to the reference's v_d', for constant error."""
    return _rate_along(ca.SX.zeros(3), e, v_d, v_d_dot, k)


def _rate_along(e_dot: ca.SX, e: ca.SX, v_d: ca.SX, v_d_dot: ca.SX, k: ca.SX) -> ca.SX:
    e_sym, v_d_sym = ca.SX.sym("e", 3), ca.SX.sym("v_d", 2)
    arguments = ca.vertcat(e_sym, v_d_sym)
    direction = ca.vertcat(e_dot, v_d_dot)
    rate = ca.jtimes(auxiliary_velocity(e_sym, v_d_sym, k), arguments, direction)
    return ca.substitute(rate, arguments, ca.vertcat(e, v_d))
