"""Late and averaged velocities."""

import pytest

from tests.papers_robot import paper
from tests.world import twins
from tests.world.motion import assert_is_twin
from wmr_ctrl.world.scenario import override
from wmr_ctrl.world.velocity_mean import VELOCITY_MEAN


@pytest.mark.parametrize("window", [0, 3])
def test_a_mean_or_a_late_velocity_is_its_twins(window):
    changes = {"sensor.velocity_window": window * 0.01, "sensor.velocity_age": 0.02}

    assert_is_twin(VELOCITY_MEAN, changes, twins.MeanTwin({"window": window, "age": 2, "T": 0.01}))


def test_a_mean_is_off_by_the_rounding_of_the_way_and_what_is_late_by_nothing():
    """2^-53 of u1 times the duration in each step, and as much for the difference."""
    scenario = override(paper(), {"sensor.velocity_window": 0.02, "sensor.velocity_age": 0.01})
    late = override(paper(), {"sensor.velocity_age": 0.01})
    share = 2 * 2.0**-53 * scenario.clock.duration / 0.001

    assert VELOCITY_MEAN.bounded(scenario).nbar == pytest.approx((share * 1.0, share * 1.5))
    assert VELOCITY_MEAN.bounded(late).nbar == (0.0, 0.0)
