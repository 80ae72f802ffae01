"""Effects of the base on commands are named as the cause if a run misses its path or goal."""

import pytest

import wmr_ctrl
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.theory.checks import warnings_for
from wmr_ctrl.world.scenario import load_scenario, loads_scenario, override

DOCK = """
extends = "irobot-create3"
frames = "rep103"
base.deadband = [0.03, 0.26]
initial.pose = [0.0, 0.0, 0.0]
clock.duration = 30.0
metrics.tolerance = 0.02
[reference]
kind = "waypoints"
points = [[0.0, 0.0], [0.6, 0.0], [1.0, 0.1]]
speed = 0.06
tolerance = 0.05
"""
DOCKING = loads_scenario(DOCK)
CREATE3 = load_scenario("irobot-create3", {"clock.duration": 20.0})


def told(run):
    return {item.key: item.text for item in run.remarks}


@pytest.mark.parametrize("law", ["pursuit", "kanayama"])
def test_a_dead_band_that_stalls_a_law_is_named(law):
    remarks = told(wmr_ctrl.simulate(DOCKING, law))
    assert "of the last 10 s the law asked for less than base.deadband" in remarks["dead-band"]
    assert "See the other remarks for the cause" in remarks["goal-not-reached"]


def test_a_base_that_arrives_is_told_nothing():
    assert not {"dead-band", "goal-not-reached"} & {*told(wmr_ctrl.simulate(DOCKING, "prox"))}
    free = override(DOCKING, {"base.deadband": [0.0, 0.0]})
    assert not {"dead-band", "goal-not-reached"} & {*told(wmr_ctrl.simulate(free, "pursuit"))}


LOSSY = "base.losses = 10; base.timeout = 0.06; metrics.tolerance = 0.03"
CAUSES = {
    "dead-band": ("base.wheel_deadband = 0.2; filter.trust = true", "base.wheel_deadband"),
    "wheel-limit": ("base.w_max = 3.0", "more than base.w_max"),
    "quantum": ("base.quantum = [0.0, 1.5]; filter.d = [0.005, 0.9]", "half of base.quantum"),
    "ramps": (
        "base.accel = [0.9, 0.1]; base.decel = [0.9, 0.1]", "faster changes than base.accel",
    ),
    "losses": (LOSSY, "within base.losses = 10 commands"),
}  # fmt: skip


@pytest.mark.parametrize("key", CAUSES)
def test_each_cause_is_named_alone(key):
    text, words = CAUSES[key]
    law = "pursuit" if key == "ramps" else "kanayama"
    remarks = told(wmr_ctrl.simulate(override(CREATE3, changes(text)), law))
    assert words in remarks[key]
    assert not ({*CAUSES} - {key}) & {*remarks}


@pytest.mark.parametrize("most", [1.05, 3.0])
def test_a_filter_that_holds_back_is_named(most):
    run = wmr_ctrl.simulate(override(CREATE3, {"filter.gain": [0.95, most]}), "kanayama")
    assert ("filter-holds-back" in told(run)) is (most > 2)


def found(stated):
    setup = settle(override(CREATE3, stated), "kanayama")
    return {item.key: item for item in warnings_for(setup)}


def test_check_notes_a_path_within_a_dead_band():
    """The circle takes 0.16 m/s and 0.2 rad/s."""
    assert "base.deadband" not in found({"base.deadband": [0.15, 0.19]})
    slow = found({"base.deadband": [0.15, 0.21]})["base.deadband"]
    assert "for 100 % of its time the path asks for less than base.deadband" in str(slow)
    assert not slow.objects
    wheel = {"base.wheel_deadband": 0.14, "filter.trust": True}
    assert "base.wheel_deadband" in found(wheel)
