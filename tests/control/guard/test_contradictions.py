"""Stated bounds that the scenario breaks are refused with the guard on, otherwise reported."""

import re

import numpy as np
import pytest

from tests.checks.asking import told_of
from tests.tables import cases, changes
from wmr_ctrl.api import simulate
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.guard.contradictions import beyond_belief, contradictions
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import load_scenario, preset_names

BROKEN = cases("""
    guard.dbar = [59, 15]                                       | 59 N, 60 N
    guard.dbar = [60, 14]                                       | [2] = 14 N m, 15 N m | slow
    guard.dbar = [70, 20]; disturbance.push = [20, 0]           | 70 N, 80 N           | slow
    guard.dbar = [60, 15]; guard.d_model = [0, 2]               | 17 N m               | slow
    guard.nbar = [0.01, 0]; sensor.velocity_noise = [0.02, 0]   | 0.02
    guard.f_min = [40.24, 0]; guard.f_speed = [0.2, 0]          | 39.24
    guard.f_min = [30, 0]; guard.f_speed = [0.001, 0]           | 3.911 N              | slow
    guard.f_min = [0, 1]; guard.f_speed = [0, 0.5]              | 0 N m                | slow
    guard.delay = [0, 0.003]; actuator.delay = 0.004            | 0.003, 0.004
    guard.delay = [0.003, 0.008]; actuator.jitter = 0.008       | 0.003, 0 and         | slow
    guard.lag = [0.01, 0.02]; actuator.lag = 0.03               | 0.02, 0.03
    guard.lag = [0.02, 0.03]; actuator.lag = 0.02               | 0.0195041            | slow
    guard.lag = [0.02, 0.02]; actuator.lag = 0.018; actuator.lag_spread = 0.1 \
                                                                | 0.0157051            | slow
""")
"""Changes that break a stated bound, the first key, and numbers that are told of it."""
MET = cases("""
    guard.dbar = [60, 15]
    guard.M_min = [50, 5.4]; guard.M_max = [65, 7]
    guard.nbar = [0.02, 0]; sensor.velocity_noise = [0.02, 0]
    guard.f_min = [39.24, 0]; guard.f_speed = [0.2, 0]
    guard.delay = [0, 0.006]; actuator.jitter = 0.005
    guard.delay = [0.01, 0.01]; actuator.delay = 0.004
    guard.lag = [0.02, 0.02]; actuator.lag = 0.01
    guard.lag = [0.01, 0.03]; actuator.lag = 0.02; actuator.lag_spread = 0.4
""")


def unsaid(numbers, text):
    """Numbers of a case that a text omits."""
    return [number for number in numbers.split(", ") if number not in text]


@pytest.mark.parametrize("changed, numbers", BROKEN)
def test_with_the_guard_on_it_is_refused_unless_trusted(changed, numbers):
    stated = changes(changed)
    key = next(iter(stated))
    with pytest.raises(ScenarioError) as refused:
        scenario_of("safe-simulation", stated)
    trusted = settle(scenario_of("safe-simulation", {**stated, "guard.trust": True}), "prox")

    assert str(refused.value).startswith(key)
    assert "guard.trust = true" in str(refused.value)
    assert unsaid(numbers, str(refused.value)) == []
    assert told_of(trusted, key)
    assert unsaid(numbers, trusted.void) == []


@pytest.mark.parametrize(
    "changed, key, numbers",
    cases("""
        guard.M_min = [50.1, 5]  | guard.M_min | mass 50 kg, 50.1 to 71.5 kg
        guard.M_max = [60, 8]    | guard.M_max | mass 65 kg from t = 40 s on, 45 to 60 kg
        guard.M_min = [45, 4.86]; guard.M_max = [71.5, 7.7]; robot.I = 9 \
                                 | guard.M_max | inertia 9 kg m2, 4.86 to 7.7 kg m2
        guard.f_min = [30, 0]; guard.f_speed = [0.2, 0]; robot.mu = 0.05; model.mu = 0.08 \
                                 | guard.f_min | 30 N, 24.53 N, robot
        guard.f_min = [30, 0]; guard.f_speed = [0.2, 0]; changes = [{t = 9.0, mu = 0.0}] \
                                 | guard.f_min | 30 N, above the 0 N
    """),
)
def test_a_robot_that_is_not_what_the_guard_is_told_is_run_without_promise(changed, key, numbers):
    setup = settle(scenario_of("safe-simulation", changes(changed)), "prox")
    told = [str(item) for item in told_of(setup, key)]

    assert any(unsaid(numbers, text) == [] for text in told), told
    assert unsaid(numbers, setup.void) == []


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
    changed = {"clock.plant": step, "robot.mu": mu}
    setup = settle(load_scenario("paper-simulation-nominal", changed), "kanayama")
    found = told_of(setup, "clock.plant")

    assert len(found) == told
    assert all(f"{step * mu * 981:.3g}" in item.sentence for item in found)


def test_an_alpha_that_noise_shakes_is_said_with_its_swing():
    """In a run along the limit, errors of the stated size cause about this swing."""
    fast = changes("""
        reference.kind = line
        reference.speed = 1.5
        disturbance.std = 0.0
        sensor.velocity_noise = [0.02, 0.0]
        guard.enabled = true
        changes = []
        clock.duration = 20.0
        gains.kanayama.share = 1.0
    """)
    scenario = load_scenario("paper-simulation", fast)
    (warning,) = told_of(settle(scenario, "kanayama"), "guard.alpha")
    swing = float(re.search(r"swing by about ([\d.]+) N m", warning.sentence)[1])
    run = simulate(scenario, "kanayama")
    late = run["tau_right"][-500:]

    assert swing == pytest.approx(4 * 0.02 * 45 * 100 * 0.05, rel=1e-2)
    assert run["clip_active"][-500:, 0].mean() > 0.5
    assert 0.5 * swing < np.ptp(late) < 1.5 * swing
    calm = changes("guard.alpha = 10.0; guard.dbar = [5.0, 1.0]")
    quiet = settle(load_scenario("paper-simulation", fast | calm), "kanayama")
    assert not told_of(quiet, "guard.alpha")


PUSH = [66.8580831, 12.34567891]
"""Push that becomes smaller if it is rounded to six digits."""


@pytest.mark.parametrize(
    "preset, key, changed, most",
    cases("""
        paper-simulation   | guard.dbar  | guard.dbar = [1, 40]     | 40
        paper-simulation   | guard.brake | guard.brake = [10, 40]   | 40
        paper-simulation   | guard.nbar  | guard.nbar = [0.01, 0.2]; \
                                           sensor.velocity_noise = [0.0654321098, 0.1] | 0.2
        turtlebot3-burger  | filter.d    | base.quantum = [0.0123456789, 0] | 0.05
    """),
)
def test_the_number_that_is_said_to_be_enough_is_enough(preset, key, changed, most):
    """The push becomes smaller when written with six digits."""
    given = changes(changed)
    if preset == "paper-simulation":
        given |= changes("disturbance.std = 0; guard.enabled = true")
        given["disturbance.push"] = [66.8580831, 12.34567891]

    with pytest.raises(ScenarioError) as refused:
        settle(scenario_of(preset, given), "kanayama")
    said = str(refused.value)
    (number,) = re.findall(r"(?:below the|dbar - f_min =|push the base on by) ([\d.]+)", said)

    assert key in said
    settle(scenario_of(preset, {**given, key: f"[{number.rstrip('.')}, {most}]"}), None)
