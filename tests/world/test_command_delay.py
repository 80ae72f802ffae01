"""The delay of commands."""

import pytest

from tests.world.motion import based
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.command_delay import COMMAND_DELAY
from wmr_ctrl.world.scenario import override


@pytest.mark.parametrize("count, possible", [(500, True), (501, False)])
def test_five_hundred_commands_may_be_under_way(count, possible):
    changed = {"clock.control": 0.01, "base": {"kind": "velocity", "delay": round(count * 0.01, 9)}}
    if possible:
        scenario = override(based(), changed)
        assert COMMAND_DELAY.bounded(scenario).delay == pytest.approx(5.0)
    else:
        with pytest.raises(ScenarioError, match=r"base\.delay = 5\.01 s is 501 times"):
            override(based(), changed)


@pytest.mark.parametrize("name", ["delay", "unmodelled_delay", "jitter"])
def test_a_base_that_takes_velocities_has_no_late_torques(name):
    with pytest.raises(ScenarioError, match=rf"actuator\.{name} = 0\.01 s delays torques"):
        override(based(), {f"actuator.{name}": 0.01})
