"""Presets against the numbers of the paper and of the project's conventions, typed by hand."""

from __future__ import annotations

import math
import pickle

import pytest

from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.world.references import Circle, Line
from wmr_ctrl.world.scenario import (
    Change,
    from_dict,
    load_scenario,
    loads_scenario,
    preset_names,
    preset_titles,
    scenario_dict,
    to_toml,
)

NAMES = (
    "paper-experiment",
    "paper-experiment-literal",
    "paper-simulation",
    "paper-simulation-no-switch",
    "paper-simulation-noise-free",
    "paper-simulation-nominal",
    "far-start",
    "far-start-drop",
    "far-start-friction-overestimated",
    "fast-reference",
    "outside-start",
)
SWITCH = (Change(t=40.0, m=65.0, I=7.0, mu=0.15),)


def test_all_are_there_and_the_papers_come_first():
    assert set(NAMES) <= set(preset_names())
    assert preset_names()[0].startswith("paper")


@pytest.mark.parametrize("name", preset_names())
def test_loads_and_is_described_in_one_line(name):
    scenario = load_scenario(name)

    assert scenario.name == name
    assert scenario.title == preset_titles()[name]
    assert 20 < len(scenario.title) < 90
    assert "\n" not in scenario.title


@pytest.mark.parametrize("name", preset_names())
@pytest.mark.parametrize("comments", [True, False])
def test_toml_loads_back_equal(name, comments):
    scenario = load_scenario(name)

    assert loads_scenario(to_toml(scenario, comments=comments), name) == scenario
    assert from_dict(scenario_dict(scenario), name) == scenario
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert hash(pickle.loads(pickle.dumps(scenario))) == hash(scenario)


@pytest.mark.parametrize("name", NAMES)
def test_what_all_presets_share(name):
    scenario = load_scenario(name)

    assert (scenario.robot.r, scenario.robot.l, scenario.robot.mu) == (0.1, 0.25, 0.08)
    assert (scenario.robot.g, scenario.robot.v_s) == (9.81, 0.01)
    assert (scenario.limits.v_u1, scenario.limits.v_u2) == ((1.0, 1.5), (0.8, 1.3))
    assert scenario.limits.clip == 1e-6
    assert (scenario.clock.duration, scenario.clock.plant) == (80.0, 0.001)
    assert scenario.disturbance.truncate in (6.0, math.inf)
    assert scenario.actuator.ideal
    assert scenario.actuator.tau_max == math.inf
    assert (scenario.split, scenario.metrics.rms_from) == (40.0, 2.0)


def simulation(name):
    """Check what the four simulations share; return noise and changes."""
    scenario = load_scenario(name)
    assert (scenario.robot.m, scenario.robot.I) == (50.0, 5.4)
    assert scenario.initial.pose == (-0.5, -0.5, -0.7)
    assert scenario.initial.velocity == (0.0, 0.0)
    assert scenario.reference == Circle(radius=2.0, rate=0.1)
    assert (scenario.clock.control, scenario.clock.substeps) == (0.01, 10)
    assert scenario.clock.samples == 8000
    assert scenario.sensor.perfect
    assert scenario.believed == scenario.robot
    return scenario.disturbance.std, scenario.changes


def test_simulations():
    assert simulation("paper-simulation") == (1.0, SWITCH)
    assert simulation("paper-simulation-no-switch") == (1.0, ())
    assert simulation("paper-simulation-noise-free") == (0.0, SWITCH)
    assert simulation("paper-simulation-nominal") == (0.0, ())


def test_experiment():
    scenario = load_scenario("paper-experiment")

    assert scenario.robot.m == 80.0
    assert abs(scenario.robot.I - 80.0 * (0.8**2 + 0.5**2) / 12) < 1e-14
    assert scenario.believed == scenario.robot
    assert scenario.disturbance.std == 1.0
    assert scenario.changes == ()
    assert scenario.clock.control == 0.01
    assert scenario.sensor.pose_period == 0.1
    assert scenario.sensor.pose_noise == 0.05
    assert scenario.sensor.velocity_noise == (0.0, 0.0)
    assert scenario.sensor.correction == 0.2
    assert not scenario.sensor.perfect


def test_literal_experiment_only_holds_the_torque_longer():
    literal, usual = load_scenario("paper-experiment-literal"), load_scenario("paper-experiment")
    ours, theirs = scenario_dict(literal), scenario_dict(usual)

    assert (literal.clock.control, literal.clock.substeps, literal.clock.samples) == (0.1, 100, 800)
    assert {key for key in ours if ours[key] != theirs[key]} == {"title", "clock"}


def test_stress_cases():
    far = load_scenario("far-start")
    believing = load_scenario("far-start-friction-overestimated")
    drop = load_scenario("far-start-drop")

    assert far.initial.pose == believing.initial.pose == drop.initial.pose == (-5.0, -5.0, -0.7)
    assert far.changes == believing.changes == ()
    assert (believing.believed.mu, believing.robot.mu) == (0.12, 0.08)
    assert drop.changes == (Change(t=3.0, m=25.0, I=2.7, mu=0.0),)
    assert drop.believed.m == 50.0
    assert load_scenario("outside-start").initial.velocity == (1.3, 2.0)
    assert load_scenario("outside-start").initial.pose == (-0.5, -0.5, -0.7)
    assert load_scenario("fast-reference").reference == Line(speed=0.9)


def test_unknown_name_lists_the_near_ones():
    with pytest.raises(UnknownNameError, match=r"near: paper-simulation.*path"):
        load_scenario("paper-simulaton")
