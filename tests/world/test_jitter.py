"""Commands that are late by different times."""

import numpy as np
import pytest

from tests.papers_robot import paper
from tests.world.motion import fed_to, motion
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.jitter import JITTER
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize("delay, most", [(0, 6), (13, 10)])
def test_commands_arrive_at_the_beginning_of_a_period_and_wait(delay, most):
    changes = {"actuator.jitter": most / 1000, "actuator.delay": delay / 1000}
    columns = motion(late=delay)
    wanted = np.zeros_like(columns["torque"])
    for k in range(delay % 10, len(wanted), 10):
        share = (columns["jitter"][k, 0] + 1) / 2
        wanted[k + min(int(share * (most + 1)), 10) :] = columns["torque"][k]

    assert np.array_equal(fed_to(JITTER, changes, columns), wanted)


def test_a_jitter_of_a_whole_period_overtakes_nothing():
    assert override(paper(), {"actuator.jitter": 0.01}).actuator.jitter == 0.01
    with pytest.raises(ScenarioError, match="could otherwise overtake"):
        override(paper(), {"actuator.jitter": 0.011})
