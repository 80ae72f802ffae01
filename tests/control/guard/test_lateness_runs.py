"""Sensors and drives as robots have them, stated and guarded: runs, lanes, FMUs, packages."""

import pytest

from tests.control.guard.parameters import feasible_with
from tests.control.guard.test_guard_adversary import LIGHTEST
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.controller import guard as guard_alone
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario

WEAK = "guard.dbar = [40.0, 6.0]; disturbance.push = [40.0, 6.0]; clock.duration = 20"
KINDS = {
    "as a robot has it, 10 ms": """
        encoder.counts = 1024
        actuator.jitter = 0.005
        actuator.lag = 0.02
    """,
    "encoder of 256 counts over 100 ms": "clock.control = 0.1; encoder.counts = 256",
    "stated bounds of delay and lag": """
        clock.control = 0.1
        actuator.unmodelled_delay = 0.02
        actuator.lag = 0.05
        guard.delay = [0.0, 0.03]
        guard.lag = [0.02, 0.06]
    """,
}
DRIVES = changes("""
    actuator.delay = 0.003
    actuator.jitter = 0.004
    actuator.lag = 0.01
    actuator.lag_spread = 0.2
""")
SHORT = changes("""
    actuator.tau_max = 10.0
    clock.duration = 3.0
    changes = []
    disturbance.truncate = 3
""")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.slow_but("as a robot has it, 10 ms")
def test_pushed_the_way_it_moves_the_robot_stays_within_its_limits(kind):
    """The lightest robot, without friction."""
    changed = {**LIGHTEST, **changes(WEAK), **changes(KINDS[kind])}
    run = simulate("paper-simulation-nominal", "pid", guard=True, overrides=changed)
    assert run.monitor.violations == 0
    assert run.outcome == "completed"
    assert (run["feasible"] == 1).all()


def guard_of(**more):
    stated = {"guard.enabled": True, **SHORT, **DRIVES, **more}
    return guard_alone(settle(load_scenario("safe-simulation", stated), None))


@pytest.mark.parametrize("key", DRIVES)
def test_drives_slower_than_the_graph_was_built_for_are_not_feasible(key):
    assert feasible_with(guard_of(), {key: 1.01}) == 0.0
    assert feasible_with(guard_of(), {}) == 1.0


def test_drives_quicker_than_the_graph_was_built_for_are_not_feasible_where_they_vary():
    item = guard_of()
    steady = guard_of(**changes("actuator.lag_spread = 0; actuator.jitter = 0"))

    for key in ("actuator.delay", "actuator.lag"):
        assert feasible_with(item, {key: 0.95}) == 0.0
        assert feasible_with(steady, {key: 0.95}) == 1.0
    assert feasible_with(item, {"actuator.lag_spread": 0.95, "actuator.jitter": 0.95}) == 1.0
