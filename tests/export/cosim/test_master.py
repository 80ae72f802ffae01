"""Effects between controller and plant."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.control.setup import settle
from wmr_ctrl.export.cosim.master import Outside
from wmr_ctrl.world.scenario import override


def test_without_effects_everything_passes_as_it_is():
    outside = Outside(settle(override(paper(), {"disturbance.std": 0.0}), "mb"), 3)
    state = (0.1, 0.2, 0.3, 0.4, 0.5)

    now = outside.sample(state)
    assert (*now.pose, *now.velocity) == pytest.approx(state)
    assert outside.step((3.0, -1.0), now)[:2] == pytest.approx((3.0, -1.0))
    assert outside.calm
    assert outside.steady


def test_drives_that_are_late_give_what_was_asked_for_before():
    outside = Outside(settle(override(paper(), {"actuator.delay": 0.002}), "mb"), 3)
    now = outside.sample((0.0,) * 5)

    acting = [outside.step((1.0, 2.0), now)[:2] for _ in range(3)]
    assert acting == [(0.0, 0.0), (0.0, 0.0), (1.0, 2.0)]
    assert not outside.steady
