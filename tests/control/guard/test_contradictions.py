"""Bounds that a scenario states and itself breaks: refused with the guard on, else told."""

import re

import numpy as np
import pytest

from tests.checks.asking import told_of
from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.guard.contradictions import beyond_belief, contradictions
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import load_scenario, preset_names

FRICTION = 0.08 * 50 * 9.81
BROKEN = [
    ({"guard.dbar": [59.0, 15.0]}, "guard.dbar", ("59 N", "60 N")),
    ({"guard.dbar": [60.0, 14.0]}, "guard.dbar", ("[2] = 14 N m", "15 N m")),
    ({"guard.dbar": [70.0, 20.0], "disturbance.push": [20.0, 0.0]}, "guard.dbar", ("70 N", "80 N")),
    ({"guard.dbar": [60.0, 15.0], "guard.d_model": [0.0, 2.0]}, "guard.dbar", ("17 N m",)),
    ({"guard.nbar": [0.01, 0.0], "sensor.velocity_noise": [0.02, 0.0]}, "guard.nbar", ("0.02",)),
    ({"guard.f_min": [FRICTION + 1, 0.0], "guard.f_speed": [0.2, 0.0]}, "guard.f_min", ("39.24",)),
    ({"guard.f_min": [30.0, 0.0], "guard.f_speed": [0.001, 0.0]}, "guard.f_min", ("3.911 N",)),
    ({"guard.delay": [0.0, 0.003], "actuator.delay": 0.004}, "guard.delay", ("0.003", "0.004")),
    ({"guard.delay": [0.003, 0.008], "actuator.jitter": 0.008}, "guard.delay", ("0.003", "0 and")),
    ({"guard.lag": [0.01, 0.02], "actuator.lag": 0.03}, "guard.lag", ("0.02", "0.03")),
    (
        {"guard.lag": [0.02, 0.02], "actuator.lag": 0.018, "actuator.lag_spread": 0.1},
        "guard.lag",
        ("0.02", "0.0157051"),
    ),
    ({"guard.lag": [0.02, 0.03], "actuator.lag": 0.02}, "guard.lag", ("0.0195041",)),
    ({"guard.f_min": [0.0, 1.0], "guard.f_speed": [0.0, 0.5]}, "guard.f_min", ("0 N m",)),
]
LIKE_THIS = {"guard.M_min": [45.0, 4.86], "guard.M_max": [71.5, 7.7]}
SURE = {"guard.f_min": [30.0, 0.0], "guard.f_speed": [0.2, 0.0]}
UNLIKE = [
    ({"guard.M_min": [50.1, 5.0]}, "guard.M_min", ("mass 50 kg", "50.1 to 71.5 kg")),
    ({"guard.M_max": [60.0, 8.0]}, "guard.M_max", ("mass 65 kg from t = 40 s on", "45 to 60 kg")),
    ({**LIKE_THIS, "robot.I": 9.0}, "guard.M_max", ("inertia 9 kg m2", "4.86 to 7.7 kg m2")),
    ({**SURE, "robot.mu": 0.05, "model.mu": 0.08}, "guard.f_min", ("30 N", "24.53 N", "robot")),
    ({**SURE, "changes": [{"t": 9.0, "mu": 0.0}]}, "guard.f_min", ("30 N", "above the 0 N")),
]
MET = [
    {"guard.dbar": [60.0, 15.0]},
    {"guard.M_min": [50.0, 5.4], "guard.M_max": [65.0, 7.0]},
    {"guard.nbar": [0.02, 0.0], "sensor.velocity_noise": [0.02, 0.0]},
    {"guard.f_min": [FRICTION, 0.0], "guard.f_speed": [0.2, 0.0]},
    {"guard.delay": [0.0, 0.006], "actuator.jitter": 0.005},
    {"guard.delay": [0.01, 0.01], "actuator.delay": 0.004},
    {"guard.lag": [0.02, 0.02], "actuator.lag": 0.01},
    {"guard.lag": [0.01, 0.03], "actuator.lag": 0.02, "actuator.lag_spread": 0.4},
]


@pytest.mark.parametrize("changed, key, numbers", BROKEN)
@pytest.mark.slow_but(
    "changed0-guard.dbar-numbers0",
    "changed4-guard.nbar-numbers4",
    "changed5-guard.f_min-numbers5",
    "changed7-guard.delay-numbers7",
    "changed9-guard.lag-numbers9",
)
def test_with_the_guard_on_it_is_refused_unless_trusted(changed, key, numbers):
    with pytest.raises(ScenarioError) as refused:
        scenario_of("safe-simulation", changed)
    trusted = scenario_of("safe-simulation", {**changed, "guard.trust": True})

    assert str(refused.value).startswith(key)
    assert "guard.trust = true" in str(refused.value)
    assert [number for number in numbers if number not in str(refused.value)] == []
    assert told_of(settle(trusted, "kanayama"), key)
    assert [number for number in numbers if number not in settle(trusted, "prox").void] == []


@pytest.mark.parametrize("changed, key, numbers", UNLIKE)
def test_a_robot_that_is_not_what_the_guard_is_told_is_run_without_promise(changed, key, numbers):
    scenario = scenario_of("safe-simulation", changed)
    told = [str(item) for item in told_of(settle(scenario, "prox"), key)]
    void = settle(scenario, "prox").void

    assert any(all(number in text for number in numbers) for text in told), told
    assert [number for number in numbers if number not in void] == []


@pytest.mark.parametrize("name", preset_names())
def test_no_preset_contradicts_itself(name):
    scenario = load_scenario(name)

    setup = settle(scenario, "mb")
    assert list(contradictions(scenario, setup.bound)) == []
    assert list(beyond_belief(scenario, setup.guard, setup.bound)) == []


@pytest.mark.parametrize(
    "step, mu, told", [(0.001, 0.08, 0), (0.01, 0.08, 0), (0.01, 0.11, 1), (0.001, 1.1, 1)]
)
def test_a_plant_step_too_coarse_for_the_friction_is_told(step, mu, told):
    changed = {"clock.plant": step, "robot.mu": mu, "changes": [], "clock.control": 0.01}
    setup = settle(load_scenario("paper-simulation-nominal", changed), "kanayama")
    found = told_of(setup, "clock.plant")

    assert len(found) == told
    assert all(f"{step * mu * 981:.3g}" in item.sentence for item in found)


def test_an_alpha_that_noise_shakes_is_said_with_its_swing():
    """A run along the limit, with errors of the stated size, swings about so much."""
    fast = {"reference.kind": "line", "reference.speed": 1.5, "disturbance.std": 0.0,
            "sensor.velocity_noise": [0.02, 0.0], "guard.enabled": True, "changes": [],
            "clock.duration": 20.0, "gains.kanayama.share": 1.0}  # fmt: skip
    scenario = load_scenario("paper-simulation", fast)
    (warning,) = told_of(settle(scenario, "kanayama"), "guard.alpha")
    swing = float(re.search(r"swing by about ([\d.]+) N m", warning.sentence)[1])
    run = simulate(scenario, "kanayama")
    late = run["tau_right"][-500:]

    assert swing == pytest.approx(4 * 0.02 * 45 * 100 * 0.05, rel=1e-2)
    assert run["clip_active"][-500:, 0].mean() > 0.5
    assert 0.5 * swing < np.ptp(late) < 1.5 * swing
    calm = {"guard.alpha": 10.0, "guard.dbar": [5.0, 1.0]}
    quiet = settle(load_scenario("paper-simulation", fast | calm), "kanayama")
    assert not told_of(quiet, "guard.alpha")


PUSH = [66.8580831, 12.34567891]
"""As a number of six digits it is smaller."""


@pytest.mark.parametrize("key", ["guard.dbar", "guard.nbar", "guard.brake", "filter.d"])
def test_the_number_that_is_said_to_be_enough_is_enough(key):
    base = {"disturbance.std": 0.0, "disturbance.push": PUSH, "guard.enabled": True}
    preset, changed = "paper-simulation", {"guard.dbar": [1.0, 40.0]}
    if key == "guard.nbar":
        changed = {"guard.nbar": [0.01, 0.2], "sensor.velocity_noise": [0.0654321098, 0.1]}
    if key == "guard.brake":
        changed = {"guard.brake": [10.0, 40.0]}
    if key == "filter.d":
        preset, base, changed = "turtlebot3-burger", {"base.quantum": [0.0123456789, 0.0]}, {}

    with pytest.raises(ScenarioError) as refused:
        settle(scenario_of(preset, {**base, **changed}), "kanayama")
    said = str(refused.value)
    (number,) = re.findall(r"(?:below the|dbar - f_min =|push the base on by) ([\d.]+)", said)
    most = {"filter.d": 0.05, "guard.nbar": 0.2}.get(key, 40.0)

    assert key in said
    settle(scenario_of(preset, {**base, **changed, key: [float(number.rstrip(".")), most]}), None)
