"""Every output of every kind of FMU has the bits of the native run's column of that name.

All effects of the registry act together, then each other form of their graphs; FMI 2 and FMI 3.
The closed loop runs alone.  Reference, law, guard and plant are coupled in the native order.  No
column is chosen by hand.
"""

from functools import cache

import pytest

from tests.export.fmi.raw import DISCARD, ERROR, OK
from tests.export.fmi.test_fmi_equality import assert_loop_is
from tests.tables import changes
from tests.world.toys import CLOTHOID
from wmr_ctrl.api import simulate
from wmr_ctrl.core.signals import REFERENCE
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.registry import OURS
from wmr_ctrl.world.scenario import load_scenario, override

BASE = """
clock.duration = 0.3
changes = []
disturbance.std = 0.0
disturbance.truncate = 2.0
actuator.tau_max = 30.0
guard.alpha = 5.0
"""
ACTING = {
    "encoder": "encoder.counts = 4096",
    "velocity mean": "sensor.velocity_window = 0.01",
    "velocity loss": "sensor.velocity_losses = 2",
    "gyro": "gyro = {enabled = true, bias = 0.01, noise = 0.01}",
    "velocity noise": "sensor.velocity_noise = [0.002, 0.004]",
    "pose delay": "sensor.pose_delay = 0.05",
    "pose sensor": "sensor.pose_period = 0.02; sensor.pose_noise = 0.01; sensor.pose_dropout = 0.3",
    "torque noise": "disturbance.std = 0.2",
    "push": "disturbance.push = [3.0, 0.5]",
    "gust": "gust = {size = [5.0, 1.0], time = 0.1}",
    "slope": "slope = {angle = 0.01, direction = 0.5, offset = 0.02}",
    "resistance": "resistance = {rolling = [0.01, 0.012], viscous = [2.0, 0.1]}",
    "delay": "actuator.delay = 0.003; actuator.unmodelled_delay = 0.001",
    "jitter": "actuator.jitter = 0.004",
    "motor": "motor = {step = 0.02, dead_zone = 0.01}",
    "lag": "actuator.lag = 0.004; actuator.lag_spread = 0.3",
    "wheels": "wheels = {radius = [0.002, -0.001], track = 0.002}",
}
"""Settings that activate an effect, by its name."""
COUNTED, AVERAGED = "all, counted", "all, averaged"
EFFECTS = {
    **ACTING,
    "encoder over a window": "encoder = {counts = 4096, window = 0.02}",
    "encoder by time": 'encoder = {counts = 4096, method = "time"}',
    "late velocity": "sensor.velocity_age = 0.01",
    "motor that stalls": "motor = {stall = 30.0, free = 60.0}",
    "none": "",
    COUNTED: "; ".join(text for name, text in ACTING.items() if name != "velocity mean"),
    AVERAGED: "; ".join(text for name, text in ACTING.items() if name != "encoder"),
}
"""Effects one by one, other forms of their graphs, and all compatible ones at once."""
LAW = "mb"


@cache
def scenario_with(effect):
    return load_scenario("paper-simulation", changes(BASE) | changes(EFFECTS[effect]))


def test_every_effect_acts_alone():
    ours = [item for item in OURS if item.section.KEY != "base"]  # those: test_velocity_loop.py
    for name in (item.name for item in ours):
        assert [e.name for e in OURS if e.active(scenario_with(name))] == [name]
    both = {e.name for name in (COUNTED, AVERAGED) for e in OURS if e.active(scenario_with(name))}
    assert both == {item.name for item in ours}


@pytest.mark.parametrize(
    "effect, version",
    [(COUNTED, 2), (AVERAGED, 3), ("encoder over a window", 2), ("encoder by time", 3),
     ("late velocity", 2), ("motor that stalls", 3), ("delay", 2)],
)  # fmt: skip
@pytest.mark.slow
def test_the_closed_loop(raw, effect, version):
    scenario = scenario_with(effect)
    assert_loop_is(simulate(scenario, LAW), raw("closed-loop", version, scenario, LAW))


@pytest.mark.slow
def test_the_closed_loop_ends_with_the_native_run(raw):
    gains = {"gains.pid.Kp": [1e6, 1e5], "actuator.tau_max": 1e9, "clock.duration": 2.0}
    wild = override(scenario_with("none"), gains)
    run, loop = simulate(wild, "pid"), raw("closed-loop", 2, wild, "pid").new().begin()
    ends = [OK] * (run.rows - 1) + [DISCARD, ERROR]

    assert run.monitor.stop_reason == "diverged"
    assert [loop.step(k * 0.01, 0.01) for k in range(run.rows + 1)] == ends
    assert loop.get("tau_right", "tau_left") == [run["tau_right"][-1], run["tau_left"][-1]]


@pytest.mark.slow
def test_a_reference_with_memory_keeps_it_over_a_long_step(raw, monkeypatch):
    monkeypatch.setitem(REFERENCES.__dict__, "plugins", (CLOTHOID,))
    scenario = override(scenario_with("none"), {"reference.kind": CLOTHOID.name})
    run, names = simulate(scenario, LAW), [signal.name for signal in REFERENCE]
    reference = raw("reference", 2, scenario).new().begin()

    for k in (0, 10, 20):
        assert reference.get(*names) == [run[name][k] for name in names]
        assert reference.step(k * 0.01, 0.1) == OK
