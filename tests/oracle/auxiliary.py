"""Tracking error, Eq. (8), auxiliary velocity, Eq. (7), and its exact rate."""

import math


def tracking_error(target, pose):
    """Eq. (8): error ahead [m], to the left [m] and in angle [rad] of the pose (x, y, theta)."""
    x, y, theta = pose
    dx, dy = target.x - x, target.y - y
    s, c = math.sin(theta), math.cos(theta)
    return -s * dx + c * dy, -c * dx - s * dy, target.theta - theta


def auxiliary_velocity(e, target, k):
    """Eq. (7): v_c0 [m/s, rad/s] for the gains k1, k2, k3."""
    v1d, v2d = target.v1, target.v2
    return (
        v1d * math.cos(e[2]) + k[0] * e[0],
        v2d + k[1] * v1d * e[1] + k[2] * math.sin(e[2]),
    )


def auxiliary_rate(e, v, target, k):
    """Time derivative of Eq. (7) along Eqs. (33)-(35) [m/s2, rad/s2], v the measured velocity."""
    v1d, v2d = target.v1, target.v2
    s, c = math.sin(e[2]), math.cos(e[2])
    e1_dot = e[1] * v[1] - v[0] + v1d * c
    e2_dot = -e[0] * v[1] + v1d * s
    e3_dot = v2d - v[1]
    return (
        target.v1_dot * c - v1d * s * e3_dot + k[0] * e1_dot,
        target.v2_dot + k[1] * (target.v1_dot * e[1] + v1d * e2_dot) + k[2] * c * e3_dot,
    )


def reference_rate(e, target, k):
    """Part of that rate due to the reference's acceleration [m/s2, rad/s2]."""
    return target.v1_dot * math.cos(e[2]), target.v2_dot + k[1] * target.v1_dot * e[1]
