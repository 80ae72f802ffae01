"""The dead band of commands."""

import numpy as np
import pytest

from tests.world.motion import acting, based
from wmr_ctrl.world.command_dead_band import COMMAND_DEAD_BAND


def test_a_dead_band_takes_small_commands_for_zero_and_leaves_the_others():
    wanted = np.array([[0.049, -0.11], [0.051, -0.09], [-0.05, 0.1]])
    assert acting(based(deadband=[0.05, 0.1]), wanted) == pytest.approx(
        np.array([[0.0, -0.11], [0.051, 0.0], [-0.05, 0.1]])
    )


def test_what_it_drops_is_at_most_the_dead_band_and_as_good_as_all_of_it():
    """`dropped` bounds the change of a command in the dead band, where 0 acts, and is tight."""
    scenario = based(deadband=[0.05, 0.1])
    told = np.array(COMMAND_DEAD_BAND.bounded(scenario).dropped)
    wanted = np.random.default_rng(4).uniform(-2.0, 2.0, (2000, 2)) * told
    off = np.abs(acting(scenario, wanted) - wanted).max(axis=0)

    assert (off <= told).all()
    assert (off > 0.98 * told).all()
