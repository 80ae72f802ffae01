"""What is told before a guarded run."""

from __future__ import annotations

import pytest

ON = {"guard.enabled": True}


def test_late_drives_void_the_guarantee(told):
    (late,) = told("prox", {**ON, "actuator.lag": 0.02}, key="actuator.lag")

    assert "promises nothing" in late.sentence
    assert told("prox", {"actuator.lag": 0.02}, key="actuator.lag") == []


def test_a_delay_is_covered_and_a_delay_with_lag_is_not(told):
    assert told("prox", {**ON, "actuator.delay": 0.005}, key="actuator.delay") == []
    assert told("prox", {**ON, "actuator.delay": 0.005}, key="actuator.lag") == []
    assert told("prox", {**ON, "actuator.delay": 0.005, "actuator.lag": 0.02}, key="actuator.lag")


@pytest.mark.parametrize(("start", "warned"), [(0.9, False), (0.9999, True), (1.2, False)])
def test_a_start_that_a_push_can_carry_out_before_the_first_command(told, start, warned):
    changed = {**ON, "guard.dbar": [60.0, 15.0], "initial.velocity": [start, 0.0]}
    late = told("prox", {**changed, "actuator.delay": 0.005}, key="initial.velocity")
    places = [item.sentence for item in late if "first command" in item.sentence]

    assert bool(places) is warned
    assert all("0.00667 m/s" in sentence for sentence in places)
    at_once = told("prox", changed, key="initial.velocity")
    assert not [item for item in at_once if "first command" in item.sentence]


@pytest.mark.parametrize(("period", "warned"), [(0.01, False), (0.1, True)])
def test_a_reference_faster_than_the_guard_allows(told, period, warned):
    wide = {**ON, "guard.M_min": [25.0, 2.7], "guard.dbar": [60.0, 15.0], "clock.control": period}
    found = told("prox", wide, scenario="fast-reference", key="guard.dbar")

    assert bool(found) is warned
    assert all("at most 0.603 m/s" in item.sentence for item in found)


def test_a_robot_that_cannot_move_is_told(told):
    slow = {**ON, "guard.M_min": [25.0, 2.7], "guard.dbar": [60.0, 10.0], "guard.alpha": 5.0}
    narrow = {**slow, "disturbance.std": 0.0, "robot.mu": 0.15}
    (found,) = told("mb", narrow, key="guard.dbar")

    assert "no motion at all" in found.sentence


@pytest.mark.parametrize("scenario", ["safe-simulation", "safe-experiment"])
def test_our_presets_leave_enough(told, scenario):
    assert told("prox", scenario=scenario, key="guard.dbar") == []
