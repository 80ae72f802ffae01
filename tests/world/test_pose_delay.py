"""Poses that come late."""

import numpy as np

from tests.world.motion import fed_to, motion
from wmr_ctrl.world.pose_delay import POSE_DELAY


def test_late_poses_are_old_poses():
    columns = motion(30)
    pose = np.column_stack([columns[name] for name in ("x", "y", "theta")])
    wanted = pose[np.maximum(np.arange(30) - 5, 0)]

    assert np.array_equal(fed_to(POSE_DELAY, {"sensor.pose_delay": 0.05}, columns), wanted)
