"""The noise of the measured velocity."""

import pytest

from tests.world.motion import scenario
from wmr_ctrl.world.velocity_noise import VELOCITY_NOISE


def test_it_is_off_by_its_half_widths_times_what_is_drawn():
    noisy = scenario({"sensor.velocity_noise": [0.02, 0.3]})
    system = VELOCITY_NOISE.build(noisy)
    shown = system.function("shown", [system.y])([0.5, -0.1], [], system.p0, [0.5, -1.0])

    assert shown.full().ravel() == pytest.approx([0.51, -0.4])
    assert VELOCITY_NOISE.bounded(noisy).nbar == (0.02, 0.3)
