"""An inclined plane."""

import numpy as np
import pytest

from tests.world.motion import EFFECTS, fed_to, motion
from wmr_ctrl.world.slope import SLOPE


def test_gravity_is_resolved_along_the_heading_and_its_left():
    columns = motion()
    theta, pull = columns["theta"], -50 * 9.81 * np.sin(0.03) * np.array([np.cos(0.5), np.sin(0.5)])
    ahead = np.column_stack((-np.sin(theta), np.cos(theta)))
    left = np.column_stack((-ahead[:, 1], ahead[:, 0]))
    wanted = np.column_stack((ahead @ pull, 0.02 * left @ pull))

    assert fed_to(SLOPE, EFFECTS["slope"], columns) == pytest.approx(wanted, abs=1e-12)
