"""Every output of every kind of FMU has the bits of the native run's column of that name.

Whatever effects act: all of the registry together, and each other form that their graphs have; FMI
2 and FMI 3.  The closed loop runs by itself.  Reference, law, guard and plant are coupled in the
native order; no column is chosen by hand.
"""

from functools import cache

import pytest

from tests.export.fmi.raw import DISCARD, ERROR, OK
from tests.export.fmi.test_fmi_equality import assert_same
from tests.world.toys import CLOTHOID
from wmr_ctrl.api import simulate
from wmr_ctrl.core.signals import FORCE, PATH, PLANT_STATE, PSI, TIME, TORQUE
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.registry import OURS
from wmr_ctrl.world.scenario import load_scenario, override

SEED = 0
BASE = {
    "clock.duration": 0.3,
    "changes": [],
    "disturbance.std": 0.0,
    "disturbance.truncate": 2.0,
    "actuator.tau_max": 30.0,
}
ACTING = {
    "encoder": {"encoder.counts": 4096},
    "velocity mean": {"sensor.velocity_window": 0.01},
    "velocity loss": {"sensor.velocity_losses": 2},
    "gyro": {"gyro.enabled": True, "gyro.bias": 0.01, "gyro.noise": 0.01},
    "velocity noise": {"sensor.velocity_noise": [0.002, 0.004]},
    "pose delay": {"sensor.pose_delay": 0.05},
    "pose sensor": {
        "sensor.pose_period": 0.02,
        "sensor.pose_noise": 0.01,
        "sensor.pose_dropout": 0.3,
    },
    "torque noise": {"disturbance.std": 0.2},
    "push": {"disturbance.push": [3.0, 0.5]},
    "gust": {"gust.size": [5.0, 1.0], "gust.time": 0.1},
    "slope": {"slope.angle": 0.01, "slope.direction": 0.5, "slope.offset": 0.02},
    "resistance": {"resistance.rolling": [0.01, 0.012], "resistance.viscous": [2.0, 0.1]},
    "delay": {"actuator.delay": 0.003, "actuator.unmodelled_delay": 0.001},
    "jitter": {"actuator.jitter": 0.004},
    "motor": {"motor.step": 0.02, "motor.dead_zone": 0.01},
    "lag": {"actuator.lag": 0.004, "actuator.lag_spread": 0.3},
    "wheels": {"wheels.radius": [0.002, -0.001], "wheels.track": 0.002},
}
"""By an effect's name, what makes it act."""


def all_but(name):
    """All effects at once but one: wheels are counted, or the velocity is averaged."""
    return {key: v for n, changes in ACTING.items() if n != name for key, v in changes.items()}


FORMS = {
    "encoder over a window": {"encoder.counts": 4096, "encoder.window": 0.02},
    "encoder by time": {"encoder.counts": 4096, "encoder.method": "time"},
    "late velocity": {"sensor.velocity_age": 0.01},
    "motor that stalls": {"motor.stall": 30.0, "motor.free": 60.0},
}
"""Other forms that the graphs of effects have."""
COUNTED, AVERAGED = "all, counted", "all, averaged"
EFFECTS = {
    **ACTING, **FORMS, "none": {}, COUNTED: all_but("velocity mean"), AVERAGED: all_but("encoder")
}  # fmt: skip
LAW = "mb"
TORQUES = [item.name for item in TORQUE]
POINTS = [[0.0, 0.0], [1.0, 0.2], [2.0, 1.0], [2.5, 2.0]]
REACHED = {item.name for item in (*PLANT_STATE, PSI)}
"""What the closed loop shows at the instant that was reached; all else is of the last sample."""
UNLOGGED = {*PATH.elements, *FORCE.elements}
"""Outputs that no run logs; what stands behind them is compared."""


@cache
def scenario_with(effect, guard=False):
    base = load_scenario("paper-simulation", {**BASE, **EFFECTS[effect]})
    return override(base, {"guard.enabled": guard, "guard.alpha": 5.0})


@cache
def native(scenario, law):
    return simulate(scenario, law, seed=SEED)


def row(run, k):
    """All columns of sample k, by their elements."""
    return {name: float(run[name][k]) for signal in run.signals for name in signal.elements}


def shown(part):
    """Every output."""
    found = {}
    for v in part.fmu.variables.values():
        if v.causality == "output":
            integer = v.type in ("Integer", "Int64")
            found |= {v.name: part.integer(v.name) if integer else part.get(v.name)[0]}
    return found


def different(found, wanted):
    """Outputs with other bits than the column of their name."""
    return [n for n, v in found.items() if n not in UNLOGGED and v.hex() != wanted[n].hex()]


def test_every_effect_acts_alone():
    ours = [item for item in OURS if item.section.KEY != "base"]  # those: test_velocity_loop.py
    for name in (item.name for item in ours):
        assert [e.name for e in OURS if e.active(scenario_with(name))] == [name]
    both = {e.name for name in (COUNTED, AVERAGED) for e in OURS if e.active(scenario_with(name))}
    assert both == {item.name for item in ours}


@pytest.mark.parametrize(
    "effect, version",
    [
        (COUNTED, 2),
        (AVERAGED, 3),
        ("encoder over a window", 2),
        ("encoder by time", 3),
        ("late velocity", 2),
        ("motor that stalls", 3),
        ("delay", 2),
        ("none", 3),
    ],
)
@pytest.mark.slow
def test_the_closed_loop(raw, effect, version):
    scenario = scenario_with(effect)
    run, loop = native(scenario, LAW), raw("closed-loop", version, scenario, LAW).new().begin()
    rows, period = [row(run, k) for k in range(run.rows)], scenario.clock.control
    start, watched = shown(loop), {"max_abs_v[1]", "max_abs_v[2]", "violations"}

    assert start.keys() - watched == rows[0].keys() - {TIME.name}
    assert different({n: v for n, v in start.items() if n not in watched}, rows[0]) == []
    for k in range(run.rows):
        assert loop.step(k * period, period) == OK
        found = shown(loop)
        sampled = {n: v for n, v in found.items() if n not in REACHED | watched}
        assert different(sampled, rows[k]) == [], k
        if k + 1 < run.rows:
            assert different({n: found[n] for n in REACHED}, rows[k + 1]) == [], k
    most = run.monitor.max_abs_v
    assert (found["max_abs_v[1]"], found["max_abs_v[2]"]) == most
    assert found["violations"] == run.monitor.violations


@pytest.mark.slow
def test_the_closed_loop_ends_with_the_native_run(raw):
    gains = {"gains.pid.Kp": [1e6, 1e5], "actuator.tau_max": 1e9, "clock.duration": 2.0}
    wild = override(scenario_with("none"), gains)
    run, loop = native(wild, "pid"), raw("closed-loop", 2, wild, "pid").new().begin()
    period, last = wild.clock.control, run.rows - 1

    assert run.monitor.stop_reason == "diverged"
    assert [loop.step(k * period, period) for k in range(last)] == [OK] * last
    assert loop.step(last * period, period) == DISCARD
    assert different({n: v for n, v in shown(loop).items() if n in TORQUES}, row(run, last)) == []
    assert loop.step(run.rows * period, period) == ERROR


@pytest.mark.parametrize("effect, version, guard", [(COUNTED, 2, False), (AVERAGED, 3, True)])
@pytest.mark.slow
def test_the_parts(effect, version, guard):
    scenario = scenario_with(effect, guard)
    assert_same(native(scenario, LAW), cosimulate(scenario, LAW, fmi=version))


@pytest.mark.parametrize(
    "kind, version",
    [("lemniscate", 2), ("stop-and-go", 2), ("waypoints", 3), ("line", 2), ("rounded-square", 3)],
)
@pytest.mark.slow
def test_references(kind, version):
    points = {"reference.points": POINTS} if kind == "waypoints" else {}
    scenario = override(scenario_with("none"), {"reference.kind": kind, **points})
    assert_same(native(scenario, LAW), cosimulate(scenario, LAW, fmi=version))


@pytest.mark.slow
def test_a_reference_with_memory_keeps_it_over_a_long_step(raw, monkeypatch):
    monkeypatch.setitem(REFERENCES.__dict__, "plugins", (CLOTHOID,))
    scenario = override(scenario_with("none"), {"reference.kind": CLOTHOID.name})
    run, period = native(scenario, LAW), scenario.clock.control
    reference = raw("reference", 2, scenario).new().begin()

    assert different(shown(reference), row(run, 0)) == []
    for k in range(0, 20, 10):
        assert reference.step(k * period, 10 * period) == OK
        assert different(shown(reference), row(run, k + 10)) == []
