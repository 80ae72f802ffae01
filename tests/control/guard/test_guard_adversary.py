"""The limit holds against the worst disturbance, and a broken bound costs its excess."""

import numpy as np
import pytest

from tests.tables import changes
from wmr_ctrl.api import simulate

LIGHT = np.array([25.0, 2.7])
LIMITS = np.array([1.0, 1.5])
LIGHTEST = changes("""
    guard.enabled = true
    guard.M_max = [70.0, 7.5]
    guard.dbar = [60.0, 15.0]
    disturbance.std = 0.0
    robot.m = 25.0
    robot.I = 2.7
    robot.mu = 0.0
    model.m = 50.0
    model.I = 5.4
    model.mu = 0.08
    disturbance.push = [60.0, 15.0]
""") | {"guard.M_min": LIGHT.tolist()}
PUSHED_OUT = {"pid", "smc", "mb", "nn"}
"""Laws that an unguarded adversary drives through a limit at every period."""


def pushed(law, period, guard=True, **changed):
    overrides = {**LIGHTEST, "clock.control": period, "clock.duration": 10.0, **changed}
    return simulate("paper-simulation-nominal", law, guard=guard, overrides=overrides)


@pytest.mark.parametrize("law, period", [("smc", 0.001), ("prox", 0.01), ("mb", 0.05), ("nn", 0.1)])
@pytest.mark.slow
def test_greedy_adversary_reaches_the_limit_and_never_passes_it(law, period):
    run = pushed(law, period)

    gap = np.array(run.monitor.max_abs_v) - LIMITS
    assert run.monitor.violations == 0
    assert run.outcome == "completed"
    if law in PUSHED_OUT:
        assert gap.max() > -1e-9
        assert pushed(law, period, guard=False).outcome != "completed"
