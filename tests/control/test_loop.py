"""Numbers of the clock: whole plant steps of a delay, and limits with room for rounding."""

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.loop import CLOCK, LoopGraphs
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario


@pytest.mark.parametrize("plant", [0.001, 0.0005, 0.002])
def test_no_delay_loses_a_step(plant):
    """In doubles, 0.043/0.001, 0.051/0.001 and 0.059/0.001 are below the whole number."""
    scenario = load_scenario("paper-simulation", {"clock.plant": plant, "actuator.delay": 0.006})
    graphs = LoopGraphs(settle(scenario, "mb"))
    names = [item.signal.name for item in graphs.parameters.ports for _ in item.value]
    numbers = np.array([value for item in graphs.parameters.ports for value in item.value])
    place = names.index("actuator.delay")

    for n in range(500):
        for delay in (n * plant, n / round(1 / plant)):
            numbers[place] = delay
            assert float(graphs.delay_steps(numbers)) == n


def test_what_rounding_adds_to_a_limit_is_no_violation():
    """An excess of some roundings is allowed, but not a part in a million million."""
    graphs = LoopGraphs(settle(load_scenario("paper-simulation"), "mb"))
    numbers = [value for item in graphs.parameters.ports for value in item.value]
    counted = ca.Function("clock", [graphs.p], [graphs.clock])(numbers)

    for axis, name in enumerate(("v_max_linear", "v_max_angular")):
        share = float(counted[CLOCK.index(name)]) / graphs.setup.scenario.limits.v_u1[axis]
        assert 1 + 4 * 2.0**-52 < share <= 1 + 1.01e-12

    rimmed = load_scenario("turtlebot3-burger", {"filter.wheel_speed": 0.2})
    graphs = LoopGraphs(settle(rimmed, "kanayama"))
    numbers = [value for item in graphs.parameters.ports for value in item.value]
    counted = ca.Function("clock", [graphs.p], [graphs.clock])(numbers)
    assert 1 + 4 * 2.0**-52 < float(counted[CLOCK.index("wheel_speed")]) / 0.2 <= 1 + 1.01e-12
