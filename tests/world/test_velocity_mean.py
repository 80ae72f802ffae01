"""Late and averaged velocities."""

import numpy as np
import pytest

from tests.papers_robot import paper
from tests.world.motion import fed_to, motion
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.velocity_mean import VELOCITY_MEAN


@pytest.mark.parametrize("window", [0, 3])
def test_a_mean_or_a_late_velocity_is_of_the_samples_before(window):
    changes = {"sensor.velocity_window": window * 0.01, "sensor.velocity_age": 0.02}
    columns, rows = motion(), np.arange(400)
    end, begin = (np.maximum(rows - back, 0) for back in (2, 2 + window))
    if window:
        way = np.column_stack((columns["path"], columns["theta"]))
        wanted = (way[end] - way[begin]) / (window * 0.01)
    else:
        wanted = np.column_stack((columns["v1"], columns["omega"]))[end]

    assert fed_to(VELOCITY_MEAN, changes, columns) == pytest.approx(wanted, abs=1e-12)


def test_a_mean_is_off_by_the_rounding_of_the_way_and_what_is_late_by_nothing():
    """The error is 2^-53 of u1 times the duration in each step, and as much for the difference."""
    scenario = override(paper(), {"sensor.velocity_window": 0.02, "sensor.velocity_age": 0.01})
    late = override(paper(), {"sensor.velocity_age": 0.01})
    share = 2 * 2.0**-53 * scenario.clock.duration / 0.001

    assert VELOCITY_MEAN.bounded(scenario).nbar == pytest.approx((share * 1.0, share * 1.5))
    assert VELOCITY_MEAN.bounded(late).nbar == (0.0, 0.0)
