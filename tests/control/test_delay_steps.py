"""A delay is so many whole plant steps, whatever the division's rounding says."""

from __future__ import annotations

import numpy as np
import pytest

from wmr_ctrl.control.loop import LoopGraphs
from wmr_ctrl.control.setup import settle
from wmr_ctrl.scenario import load_scenario


@pytest.mark.parametrize("plant", [0.001, 0.0005, 0.002])
def test_no_delay_loses_a_step(plant: float) -> None:
    """0.043/0.001, 0.051/0.001 and 0.059/0.001 are below the whole number in doubles, too."""
    scenario = load_scenario("paper-simulation", {"clock.plant": plant, "actuator.delay": 0.006})
    graphs = LoopGraphs(settle(scenario, "mb"))
    names = [item.signal.name for item in graphs.parameters.ports for _ in item.value]
    numbers = np.array([value for item in graphs.parameters.ports for value in item.value])
    place = names.index("actuator.delay")

    for n in range(500):
        for delay in (n * plant, n / round(1 / plant)):
            numbers[place] = delay
            assert float(graphs.delay_steps(numbers)) == n
