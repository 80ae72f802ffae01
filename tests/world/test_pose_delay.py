"""Poses that come late."""

import numpy as np

from tests.world.motion import fed, rows, scenario
from wmr_ctrl.world.pose_delay import POSE_DELAY


def test_late_poses_are_old_poses():
    motion = rows(30, np.random.default_rng(9))
    shown = fed(POSE_DELAY.build(scenario({"sensor.pose_delay": 0.05})), motion)
    pose = [[row[n][0] for n in ("x", "y", "theta")] for row in motion]

    assert np.array_equal(shown, [pose[max(0, k - 5)] for k in range(30)])
