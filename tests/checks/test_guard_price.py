"""What is told before a guarded run."""

from __future__ import annotations

import pytest

ON = {"guard.enabled": True}


def test_late_drives_void_the_guarantee(told):
    (late,) = told("prox", {**ON, "actuator.lag": 0.02}, key="actuator.lag")

    assert "promises nothing" in late.sentence
    assert told("prox", {"actuator.lag": 0.02}, key="actuator.lag") == []


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
