"""FMUs of a base that takes velocities: its closed loop, and its parts coupled."""

import numpy as np
import pytest

from tests.export.fmi.test_fmi_equality import assert_loop_is
from tests.tables import changes
from wmr_ctrl import simulate
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.export.cosim import cosimulate
from wmr_ctrl.world.scenario import load_scenario, loads_scenario, override

SCENARIO = override(load_scenario("paper-simulation-noise-free"), changes("""
    base = {kind = "velocity", tau = [0.2, 0.25], gain = [1.05, 0.95], delay = 0.02, losses = 2}
    base.accel = [2.0, 5.0]
    base.deadband = [0.01, 0.01]
    base.quantum = [0.01, 0.01]
    base.w_max = 11.0
    filter = {kind = "clip", gain = [0.9, 1.1], d = [0.01, 0.01]}
    clock = {control = 0.05, duration = 1.0}
    changes = [{t = 0.5, m = 65.0}]
"""))  # fmt: skip
LAW = "kanayama"
SIZELESS = loads_scenario("""
clock = { control = 0.05, duration = 1.0 }
base = { kind = "velocity", tau = [0.1, 0.1] }
limits = { v_u1 = [0.5, 1.0] }
reference = { kind = "circle", radius = 0.8, rate = 0.2 }
initial = { pose = [-0.2, -0.2, -0.7], velocity = [0, 0] }
""")
BURGER = load_scenario("turtlebot3-burger", {"clock.duration": 6.0})
BARE = override(BURGER, {"filter.kind": "none"})
QUIET = override(BURGER, {"disturbance.std": 0.0})
LOST = {"sensor.velocity_losses": 2, "sensor.velocity_age": 0.05, "filter.age": 0.16}
BASE = '''
import math
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class TheirBase(Fmi2Slave):
    """A differential drive that takes speeds of its wheels in rpm, or velocities."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for name in ("right", "left", "vel", "turn", "v", "w"):
            setattr(self, name, 0.0)
        self.px, self.py, self.yaw = -0.2, -0.2, -0.7 + math.pi / 2
        for name in ("right", "left", "vel", "turn"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("px", "py", "yaw", "v", "w"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, t, h):
        r, half, n = 0.033, 0.08, 50
        right, left = (2 * math.pi / 60 * side for side in (self.right, self.left))
        v, w = self.vel + r * (right + left) / 2, self.turn + r * (right - left) / (2 * half)
        for _ in range(n):
            self.v += h / n * (v - self.v) / 0.1
            self.w += h / n * (w - self.w) / 0.1
            self.px += h / n * self.v * math.cos(self.yaw)
            self.py += h / n * self.v * math.sin(self.yaw)
            self.yaw += h / n * self.w
        return True
'''
OUTPUTS = 'outputs = { x = "px", y = "py", psi = "yaw", v1 = "v", omega = "w" }'
PLANT = f'[plant]\nunits = "SI"\n{OUTPUTS}\n[plant.inputs]\n'
BY_VELOCITY = f'{PLANT}vel = "v_command"\nturn = "omega_command"\n'
BY_WHEELS = (
    f'{PLANT}right = {{ terms = {{ w_right_command = 1 }}, unit = "rpm" }}\n'
    'left = { terms = { w_left_command = 1 }, unit = "rpm" }\n'
)
PILOT = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Pilot(Fmi2Slave):
    """Full speed in a curve, as velocities and as speeds of the wheels."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.v, self.w, self.right, self.left = 0.5, 1.0, 0.58 / 0.033, 0.42 / 0.033
        for name in ("v", "w", "right", "left"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, t, h):
        return True
'''
ASKS = '[controller]\nunits = "SI"\noutputs = { v_command = "v", omega_command = "w" }\n'
TURNS = ASKS.replace("v_command", "w_right_command").replace("omega_c", "w_left_c")
TURNS = TURNS.replace('"v"', '"right"').replace('"w"', '"left"')


@pytest.mark.slow
def test_the_closed_loop_fmu_has_the_bits_of_the_run(raw):
    assert_loop_is(simulate(SCENARIO, LAW), raw("closed-loop", 3, SCENARIO, LAW))


@pytest.mark.parametrize(
    "case, law",
    [
        (SCENARIO, LAW), (BURGER, "prox"), (override(BURGER, LOST), "mb"),
        (override(BARE, {"base.loop": "pi"}), "mb"),
        (override(BARE, {"base.loop": ["second-order", "pi"]}), "mb"),
        (override(BURGER, {"frames": "rep103", "filter.kind": "clip"}), LAW),
    ],
)  # fmt: skip
def test_coupled_parts_are_the_native_loop(case, law):
    native, coupled = (simulate(case, law, seed=3, engine=name) for name in ("native", "fmu"))
    assert native.signals == coupled.signals
    assert native.monitor == coupled.monitor
    for name in native.columns:
        assert np.allclose(native[name], coupled[name], rtol=0, atol=1e-9, equal_nan=True), name


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.slow_but("3")
def test_a_law_of_ours_is_filtered_inside_or_from_outside(version, exported):
    native = simulate(BURGER, "mb", seed=2)
    for made in (BURGER, BARE):
        run = cosimulate(BURGER, controller=exported("mb", version, made), seed=2)
        apart = run.provenance.get("fmu_filter", "")
        assert apart.startswith("wmr_filter") is (made is BARE)
        for name in ("x", "v_command", "omega_command", "clip_active", "filter_flags", "v_asked"):
            assert np.array_equal(native[name], run[name]), name


def test_a_law_that_relies_on_what_it_sent_is_not_filtered_from_outside(exported):
    with pytest.raises(ArgumentError, match="contains no filter, and prox relies on the velocity"):
        cosimulate(BURGER, controller=exported("prox", 2, BARE))


def test_a_foreign_base_takes_velocities_or_speeds_of_its_wheels(foreign, mapped):
    """It replaces all of [base]; with the same numbers it drives as ours does."""
    file = foreign("TheirBase", BASE)
    native = simulate(override(QUIET, {"base.delay": 0.0}), LAW)
    runs = [
        cosimulate(QUIET, LAW, plant=file, map_file=mapped(m)) for m in (BY_VELOCITY, BY_WHEELS)
    ]
    assert np.abs(runs[0]["x"] - runs[1]["x"]).max() < 1e-9
    assert np.abs(runs[0]["x"] - native["x"]).max() < 2e-3
    assert np.isnan(runs[0]["tau_right"]).all()
    assert [run.outcome for run in runs] == ["completed"] * 2


def test_a_foreign_controller_is_filtered(foreign, mapped):
    file = foreign("Pilot", PILOT)
    runs = [cosimulate(QUIET, controller=file, map_file=mapped(m)) for m in (ASKS, TURNS)]
    free = override(QUIET, {"filter.kind": "none"})
    wild = cosimulate(free, controller=file, map_file=mapped(ASKS))

    run = runs[0]
    assert np.abs(run["v1"] - runs[1]["v1"]).max() < 1e-9
    assert run.monitor.violations == 0 < wild.monitor.violations
    assert run["clip_active"].any()
    assert (run["v_asked"] == [0.5, 1.0]).all()
    assert None not in map(run.summary().get, ("filter_share", "kept"))


def test_a_master_that_steps_all_at_once_voids_the_filters_assumption():
    run = cosimulate(BURGER, LAW, master="jacobi")
    assert any(
        item.key == "assumption-void" and "filter.delay" in item.text for item in run.remarks
    )
    with pytest.raises(ArgumentError, match=r"state base\.delay and filter\.delay larger"):
        cosimulate(BURGER, LAW, master="jacobi", delay_known=True)


@pytest.mark.parametrize(
    "case, text, words",
    [
        (BURGER, BY_VELOCITY, r"does not reach .* \(disturbance\.std = 0\)"),
        (SIZELESS, BY_WHEELS, r"w_left_command, w_right_command, which follow from robot\.r"),
        (load_scenario("paper-simulation-nominal"), BY_VELOCITY, "the scenario's robot takes torq"),
        (QUIET, PLANT, "no command. Add rows for v_command, omega_command, tau_right"),
    ],
)
def test_maps_that_do_not_fit_the_base_are_refused(foreign, mapped, case, text, words):
    with pytest.raises((ArgumentError, ScenarioError), match=words):
        cosimulate(case, LAW, plant=foreign("TheirBase", BASE), map_file=mapped(text))
