"""Sensors and drives as robots have them, stated and guarded: runs, lanes, FMUs, packages."""

import numpy as np
import pytest

from tests.control.guard.parameters import feasible_with
from tests.control.guard.test_guard_adversary import LIGHTEST, LIMITS
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.controller import guard as guard_alone
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario

SLOW_SAMPLE = {"clock.control": 0.1}
KINDS = {
    "encoder of 256 counts over 100 ms": {**SLOW_SAMPLE, "encoder.counts": 256.0},
    "late by 100 ms": {**SLOW_SAMPLE, "sensor.velocity_age": 0.1},
    "untold delay": {**SLOW_SAMPLE, "actuator.unmodelled_delay": 0.05},
    "as a robot has it, 10 ms": changes("""
        encoder.counts = 1024.0
        actuator.jitter = 0.005
        actuator.lag = 0.02
    """),
}  # fmt: skip
WEAK = changes("guard.dbar = [40.0, 6.0]; disturbance.push = [40.0, 6.0]")
DRIVES = changes("""
    actuator.delay = 0.003
    actuator.jitter = 0.004
    actuator.lag = 0.01
    actuator.lag_spread = 0.2
""")
RANGES = {
    "lag between bounds": {**SLOW_SAMPLE, "actuator.lag": 0.05, "actuator.lag_spread": 0.4},
    "stated bounds of delay and lag": SLOW_SAMPLE | changes("""
        actuator.unmodelled_delay = 0.02
        actuator.lag = 0.05
        guard.delay = [0.0, 0.03]
        guard.lag = [0.02, 0.06]
    """),
}  # fmt: skip
SHORT = changes("""
    actuator.tau_max = 10.0
    clock.duration = 3.0
    changes = []
    disturbance.truncate = 3
""")


def checked(law, kind):
    """The lightest robot without friction, pushed the way it moves."""
    changed = {**LIGHTEST, **WEAK, **{**KINDS, **RANGES}[kind], "clock.duration": 20.0}
    run = simulate("paper-simulation-nominal", law, guard=True, overrides=changed)
    assert run.monitor.violations == 0
    assert (np.array(run.monitor.max_abs_v) <= LIMITS).all()
    assert run.outcome == "completed"
    assert (run["feasible"] == 1).all()


@pytest.mark.parametrize(
    "law, kind",
    [
        ("pid", "as a robot has it, 10 ms"),
        pytest.param("pid", "encoder of 256 counts over 100 ms", marks=pytest.mark.slow),
        pytest.param("pursuit", "as a robot has it, 10 ms", marks=pytest.mark.slow),
        pytest.param("mb", "late by 100 ms", marks=pytest.mark.slow),
        pytest.param("prox", "untold delay", marks=pytest.mark.slow),
    ],
)
def test_pushed_the_way_it_moves_the_robot_stays_within_its_limits(law, kind):
    checked(law, kind)


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
