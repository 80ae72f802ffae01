"""Tracking error in the robot's frame, Eqs. (8), (33)-(35)."""

from __future__ import annotations

from wmr_ctrl.symbolic import ca


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
