"""Commands that come late by a time of their own."""

import pytest

from tests.papers_robot import paper
from tests.world import twins
from tests.world.motion import assert_is_twin
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.jitter import JITTER
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize("delay, most", [(0, 6), (13, 10)])
def test_it_acts_when_its_twin_does(delay, most):
    changes = {"actuator.jitter": most / 1000, "actuator.delay": delay / 1000}
    twin = twins.JitterTwin({"delay": delay, "steps": 10, "most": most})

    assert_is_twin(JITTER, changes, twin, late=delay)


def test_a_jitter_of_a_whole_period_overtakes_nothing():
    assert override(paper(), {"actuator.jitter": 0.01}).actuator.jitter == 0.01
    with pytest.raises(ScenarioError, match="could otherwise overtake"):
        override(paper(), {"actuator.jitter": 0.011})
