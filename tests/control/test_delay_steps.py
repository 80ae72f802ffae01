"""A delay is so many whole plant steps, whatever the division's rounding says."""

from __future__ import annotations

import casadi as ca
import pytest

from wmr_ctrl.control.loop import CLOCK, clock_numbers
from wmr_ctrl.model.system import Parameters
from wmr_ctrl.scenario import load_scenario


@pytest.mark.parametrize("plant", [0.001, 0.0005, 0.002])
def test_no_delay_loses_a_step(plant: float) -> None:
    """0.043/0.001, 0.051/0.001 and 0.059/0.001 are below the whole number in doubles, too."""
    p = Parameters(load_scenario("paper-simulation", {"clock.plant": plant}))
    late = ca.SX.sym("late")
    steps = clock_numbers(p, late, ())[CLOCK.index("delay_steps")]
    values = [value for item in p.ports for value in item.value]
    of = ca.Function("steps", [late, ca.vertcat(*(item.sym for item in p.ports))], [steps])

    for n in range(500):
        assert float(of(n * plant, values)) == float(of(n / round(1 / plant), values)) == n
