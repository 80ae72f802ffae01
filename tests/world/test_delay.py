"""The delay of the drives, in periods and plant steps."""

import pytest

from tests.papers_robot import paper
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
