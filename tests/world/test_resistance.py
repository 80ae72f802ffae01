"""Rolling resistance and viscous friction."""

import numpy as np
import pytest

from tests.world.motion import EFFECTS, fed_to, motion
from wmr_ctrl.world.resistance import RESISTANCE


def test_each_wheel_resists_with_its_arm_and_speeds_with_friction():
    columns = motion()
    v, omega = columns["v1"], columns["omega"]
    right, left = (
        -share * 50 * 9.81 / 2 * np.tanh((v + side * 0.25 * omega) / 0.01)
        for share, side in ((0.01, 1), (0.012, -1))
    )
    wanted = np.column_stack((right + left - 2.0 * v, 0.25 * (right - left) - 0.1 * omega))

    assert fed_to(RESISTANCE, EFFECTS["resistance"], columns) == pytest.approx(wanted, abs=1e-12)
