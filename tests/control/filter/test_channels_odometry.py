"""Odometry that comes late or not at all: the limit is kept."""

import pytest

import wmr_ctrl
from tests.control.bases import GOVERNED, based
from tests.tables import changes
from wmr_ctrl.control.filter.channels import UNUSED
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError

AGED = [(0, 3), (2, 0), (2, 2)]
"""Samples by which odometry is late, and how many in a row may be lost."""


def aged(late, lost, **more):
    stated = {"sensor.velocity_age": 0.05 * late, "sensor.velocity_losses": lost}
    return based({**GOVERNED, **stated, **more})


@pytest.mark.parametrize("late, lost", AGED)
@pytest.mark.slow_but("2-2")
def test_odometry_that_is_late_or_lost_leaves_the_limit_kept(late, lost):
    far = changes("initial.pose = [-2, -2, -0.7]; base.tau = [0.2, 0.25]; base.gain = [1.1, 1.1]")
    for age in (0.0, 0.2):
        heard = aged(late, lost, **far, **{"filter.age": age})
        run = wmr_ctrl.simulate(heard, "kanayama", engine="numpy")
        unused = has(run["filter_flags"], UNUSED)
        assert run.monitor.violations == 0
        assert unused.any() if age == 0 else unused.mean() < 0.1  # the start, where late


def has(flags, bit):
    return (flags.astype(int) & bit) > 0


def test_odometry_that_is_late_on_one_axis_alone_is_refused():
    one = based(GOVERNED, "sensor.velocity_age = 0.1; gyro.enabled = true")
    with pytest.raises(ScenarioError, match=r"sensor.velocity_age: one axis.*gyro"):
        settle(one, "kanayama")
