"""Kinematics against their mathematical definitions."""

import casadi as ca
import numpy as np

from wmr_ctrl.world.model.kinematics import error_rate, error_rotation, pose_rate, tracking_error
from wmr_proofs.paper_functions import velocity_map

ANGLES = np.linspace(-7.0, 7.0, 29)


def value(expression, symbols, *numbers):
    return ca.Function("value", symbols, [expression])(*numbers).full()


def test_pose_rate_is_h_times_v():
    theta, v = ca.SX.sym("theta"), ca.SX.sym("v", 2)
    gap = pose_rate(theta, v) - velocity_map(theta) @ v

    assert all(not value(gap, [theta, v], angle, (0.3, -1.1)).any() for angle in ANGLES)


def test_tracking_error_is_the_rotation_of_the_difference():
    pose_d, pose = ca.SX.sym("pose_d", 3), ca.SX.sym("pose", 3)
    gap = tracking_error(pose_d, pose) - error_rotation(pose[2]) @ (pose_d - pose)

    assert abs(value(gap, [pose_d, pose], (1, 2, 3), (-0.5, 0.4, 0.9))).max() < 1e-15


def test_error_rate_follows_from_both_kinematics():
    """Eqs. (33)-(35) are the derivative of Eq. (8) along q' = H v, q_d' = H_d v_d."""
    pose_d, pose, v_d, v = (ca.SX.sym(n, k) for n, k in (("qd", 3), ("q", 3), ("vd", 2), ("v", 2)))
    e = tracking_error(pose_d, pose)
    moving = ca.jtimes(
        e, ca.vertcat(pose_d, pose), ca.vertcat(pose_rate(pose_d[2], v_d), pose_rate(pose[2], v))
    )
    gap = moving - error_rate(e, v, v_d)
    numbers = (1, 2, 3.0), (-1, 0.5, 0.3), (0.2, 0.1), (0.7, -1)

    assert abs(value(gap, [pose_d, pose, v_d, v], *numbers)).max() < 1e-14
