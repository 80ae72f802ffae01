"""The dead band of commands."""

from __future__ import annotations

import numpy as np
import pytest

from tests.world.motion import acting, based
from wmr_ctrl.world.command_dead_band import COMMAND_DEAD_BAND


def test_a_dead_band_takes_small_commands_for_zero_and_leaves_the_others() -> None:
    wanted = np.array([[0.049, -0.11], [0.051, -0.09], [-0.05, 0.1]])
    assert acting(based(deadband=[0.05, 0.1]), wanted) == pytest.approx(
        np.array([[0.0, -0.11], [0.051, 0.0], [-0.05, 0.1]])
    )
    assert "do not act" in COMMAND_DEAD_BAND.bounded(based(deadband=[0.05, 0.1])).hidden
