"""Motors: steps, dead zone, and less torque the faster a wheel turns."""

import numpy as np
import pytest

from tests.world.motion import EFFECTS, fed_to, motion
from wmr_ctrl.world.motor import MOTOR


def test_torque_comes_in_steps_beyond_a_dead_zone_and_falls_with_speed():
    columns = motion()
    turn = 0.25 * columns["omega"]
    speed = np.column_stack((columns["v1"] + turn, columns["v1"] - turn)) / 0.1
    torque = 0.2 * np.floor(columns["torque"] / 0.2 + 0.5)
    size = np.maximum(np.abs(torque) - 0.1, 0.0)
    drives = torque * speed > 0
    most = 20.0 * np.maximum(1 - drives * np.abs(speed) / 30.0, 0.0)

    found = fed_to(MOTOR, EFFECTS["motor"], columns)

    assert found == pytest.approx(np.copysign(np.minimum(size, most), torque), abs=1e-12)
    assert (size > most).any()
