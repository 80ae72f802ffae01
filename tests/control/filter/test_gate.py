"""The gate before a base: compiled and not, by properties that random streams must not break."""

import math

import casadi as ca
import numpy as np
import pytest

from tests.tables import changes
from wmr_ctrl.control.filter.gate import GateSettings, gate_system
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.ros2.compiled_system import Gate
from wmr_ctrl.world.scenario import load_scenario

STATED = changes("""
    limits.v_u1 = [1.0, 2.0]
    clock.control = 0.02
    filter.gain = [0.9, 1.1]
    filter.d = [0.05, 0.05]
    filter.tau = [0.2, 0.3]
""")
SETTINGS = GateSettings(odometry="required")
T = 0.02
TOP = ((1.0 - 0.05) / 1.1, (2.0 - 0.05) / 1.1)
"""Largest commands that a clip may send."""
WILD = (math.nan, math.inf, -math.inf, 1e300, -5.0, 0.0, 0.3, 2.0)


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("paper-simulation", {"filter.kind": "clip", **STATED})


@pytest.fixture(scope="module")
def gate(scenario):
    return Gate(scenario, SETTINGS)


def random_input(rng):
    pick = lambda: rng.choice(WILD) if rng.random() < 0.3 else rng.normal()  # noqa: E731
    return {
        "command": (pick(), pick()), "command_age": rng.choice([-1.0, 0.0, 0.2, 0.3, math.nan]),
        "odometry": (pick(), pick()), "odometry_age": rng.choice([-1.0, 0.0, 0.09, 0.2]),
        "elapsed": rng.choice([0.0, 0.02, 0.5, -1.0, math.nan]),
        "stop": rng.random() < 0.02, "reset": rng.random() < 0.2,
    }  # fmt: skip


@pytest.mark.slow
def test_whatever_comes_in_a_safe_command_leaves(gate):
    rng = np.random.default_rng(7)
    gate.start()
    last = np.zeros(2)
    for _ in range(2_000):
        given = random_input(rng)
        sent = np.array(gate.step(**given).command)

        assert (np.abs(sent) <= TOP).all()
        assert (np.abs(sent) <= np.abs(last) + np.multiply(SETTINGS.rise, T) + 1e-15).all()
        if given["stop"]:
            assert (sent == 0).all()
        last = sent


def test_compiled_and_interpreted_agree(scenario, gate):
    system = gate_system(scenario, SETTINGS)
    step = system.function("gate", [system.update, system.y])
    rng = np.random.default_rng(3)
    gate.start()
    x = ca.DM(system.x0)
    for _ in range(500):
        given = random_input(rng)
        x, y = step(
            ca.DM([float(n) for v in given.values() for n in np.atleast_1d(v)]), x, system.p0
        )

        assert gate.step(**given).command == tuple(y.full().ravel()[:2])


def sound(gate, **changes):
    given = {"command": (0.4, 0.2), "command_age": 0.0, "odometry_age": 0.0, **changes}
    return gate.step(**given)


def settled(gate, **changes):
    gate.start()
    for _ in range(60):
        found = sound(gate, **changes)
    return found


def test_a_sound_command_passes_as_it_is(gate):
    assert settled(gate).command == (0.4, 0.2)
    assert settled(gate).flags == ()


def test_a_large_command_keeps_its_curvature(gate):
    v, omega = settled(gate, command=(5.0, 3.0)).command

    assert omega / v == pytest.approx(0.6, rel=1e-12)
    assert v == pytest.approx(TOP[0], rel=1e-6)


@pytest.mark.parametrize(
    "changes, flag",
    [
        ({"command_age": 0.26}, "no-command"),
        ({"command_age": -1.0}, "no-command"),
        ({"command": (math.nan, 0.0)}, "no-command"),
        ({"odometry_age": 0.11}, "no-odometry"),
        ({"odometry": (1.06, 0.0)}, "too-fast"),
        ({"odometry": (math.nan, 0.0)}, "too-fast"),
    ],
)
def test_what_fails_brings_the_base_to_rest_by_the_ramp(gate, changes, flag):
    before = settled(gate).command[0]
    count = math.ceil(before / (SETTINGS.fall[0] * T)) + 1
    speeds = []
    for _ in range(count):
        found = sound(gate, **changes)
        assert flag in found.flags
        speeds.append(found.command[0])

    expected = [max(before - SETTINGS.fall[0] * T * k, 0) for k in range(1, count + 1)]
    assert speeds == pytest.approx(expected, abs=1e-12)
    assert found.command == (0.0, 0.0)
    recovers = flag != "too-fast"
    assert (sound(gate).command != (0.0, 0.0)) is recovers


def test_what_was_stopped_waits_for_a_reset(gate):
    settled(gate)
    assert sound(gate, stop=True).command == (0.0, 0.0)
    assert sound(gate).command == (0.0, 0.0)
    assert sound(gate, stop=True, reset=True).command == (0.0, 0.0)
    assert "stopped" in sound(gate).flags
    assert sound(gate, reset=True).command != (0.0, 0.0)


def test_a_gap_counts_as_one_period(gate):
    gate.start()
    assert sound(gate, elapsed=10.0).command == (SETTINGS.rise[0] * T, SETTINGS.rise[1] * T)


@pytest.mark.parametrize("since", [-1.0, -1e-9, math.nan, -math.inf])
def test_a_clock_that_does_not_go_on_ramps_nothing(gate, since):
    before = settled(gate).command
    assert gate.step((-1.0, 0.0), 0.0, (0.0, 0.0), 0.0, since).command == before
    assert sound(gate, elapsed=since, stop=True).command == (0.0, 0.0)


def test_a_governor_has_a_gate_as_well():
    scenario = load_scenario("paper-simulation", {"filter.kind": "governor", **STATED})
    gate = Gate(scenario, GateSettings(odometry="none"))
    found = [gate.step((0.4, 0.2), 0.0) for _ in range(60)][-1]

    assert found.command == (0.4, 0.2)


@pytest.mark.parametrize(
    "changes",
    [{"odometry": "sometimes"}, {"command_timeout": 0.0}, {"rise": (1.0, math.nan)},
     {"fall": (-1.0, 1.0)}, {"excess": (math.inf, 1.0)}],
)  # fmt: skip
def test_settings_that_no_gate_keeps_are_refused(changes):
    with pytest.raises(ArgumentError, match=next(iter(changes))):
        GateSettings(**changes)
