"""The delay of the drives, in periods and plant steps."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.delay import DELAY, commands_in_flight, delay_in_periods, in_periods
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize(
    "late, parts, count", [(0.0, (0, 0), 0), (0.01, (1, 0), 1), (0.013, (1, 3), 2)]
)
def test_a_command_is_under_way_for_periods_and_steps(late, parts, count):
    scenario = override(paper(), {"actuator.delay": late, "actuator.unmodelled_delay": 0.004})

    assert delay_in_periods(scenario) == in_periods(late, scenario) == parts
    assert commands_in_flight(scenario) == count
    assert DELAY.bounded(scenario).delay == pytest.approx(late + 0.004)


def test_an_observer_keeps_five_hundred_commands_and_no_more():
    assert override(paper(), {"actuator.delay": 5.0}).actuator.delay == 5.0
    with pytest.raises(ScenarioError, match=r"actuator\.delay = 5\.01 s is 501 times"):
        override(paper(), {"actuator.delay": 5.01})
