"""Wheels that differ from the believed ones."""

import numpy as np
import pytest

from tests.world.motion import EFFECTS, fed_to, motion
from wmr_ctrl.world.wheels import WHEELS


def test_wheels_turn_torque_into_force_as_their_size_says():
    """The result is the torque at believed wheels that causes the true forces and moments."""
    columns = motion(100)
    right, left = (columns["torque"] / (0.1 * (1 + np.array([0.02, -0.01])))).T
    thrust, moment = right + left, 0.25 * 1.02 * (right - left)
    wanted = 0.1 * np.column_stack((thrust + moment / 0.25, thrust - moment / 0.25)) / 2

    assert fed_to(WHEELS, EFFECTS["wheels"], columns) == pytest.approx(wanted, rel=1e-12)
