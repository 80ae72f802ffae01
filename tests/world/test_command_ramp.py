"""The acceleration limit of the firmware."""

import numpy as np
import pytest

from tests.world.motion import acting, based
from wmr_ctrl.world.command_ramp import COMMAND_RAMP, keeps_wheels, quick_stops


def test_a_ramp_grows_and_shrinks_at_its_rates_and_never_passes_its_command():
    wanted = np.repeat([[0.5, 1.0], [-0.4, -2.0], [0.0, 0.0]], 900, axis=0)
    found = acting(based(accel=[1.0, 4.0], decel=[2.0, 8.0]), wanted)
    steps = np.diff(np.vstack((np.zeros((1, 2)), found)), axis=0)
    away = np.sign(steps) == np.sign(found)
    assert (np.abs(steps) <= np.where(away, [1e-3, 4e-3], [2e-3, 8e-3]) + 1e-12).all()
    assert found[[899, 1799, 2699]] == pytest.approx(wanted[[899, 1799, 2699]])
    assert np.abs(found).max(axis=0) == pytest.approx(np.abs(wanted).max(axis=0))


@pytest.mark.parametrize("accel, decel, kept", [
    ([1.0, 4.0], [1.0, 4.0], True), ([1.0, 4.0], [1.0, 3.9], False),
    ([1.0, 4.0], [0.99, 4.0], False),
])  # fmt: skip
def test_each_axis_stops_no_slower_than_the_other_starts_at_the_rim(accel, decel, kept):
    """Half the track is 0.25 m: 4 rad/s2 are 1 m/s2 there."""
    scenario = based(accel=accel, decel=decel)

    assert keeps_wheels(scenario) is kept
    assert quick_stops(scenario) == ", or state base.decel = [1, 4] or more"
    assert "ramps" in COMMAND_RAMP.bounded(scenario).hidden
