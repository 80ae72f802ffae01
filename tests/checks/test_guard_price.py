"""What is told before a guarded run."""

from __future__ import annotations

import pytest

from wmr_ctrl.checks.guard_price import slowest

ON = {"guard.enabled": True}


def test_a_window_that_no_theorem_knows_voids_the_guarantee(told):
    timed = {"encoder.counts": 4096.0, "encoder.method": "time"}
    (void,) = told("prox", {**ON, **timed}, key="encoder.method")

    assert "the guard knows one fixed window" in void.sentence
    assert told("prox", timed, key="encoder.method") == []


def test_delay_lag_and_jitter_are_covered(told):
    late = {"actuator.delay": 0.005, "actuator.lag": 0.02, "actuator.jitter": 0.005}
    for key in late:
        assert told("prox", {**ON, **late}, key=key) == []


def test_a_reference_too_fast_for_a_late_velocity_names_what_no_guard_can_beat(told):
    late = {**ON, "guard.M_min": [45.0, 4.86], "guard.dbar": [60.0, 15.0], "clock.control": 0.1}
    more = {"sensor.velocity_window": 0.1}
    (warning,) = told("pid", {**late, **more}, scenario="fast-reference", key="guard.dbar")

    assert "(1/alpha + age + window/2 + delay + lag)" in warning.sentence
    assert "No guard at all could leave more than 0.779 m/s" in warning.sentence
    assert "at most 0.669 m/s" in warning.sentence


@pytest.mark.parametrize(
    ("start", "warned"), [(0.9, False), (0.9999, True), (1.0, True), (1.2, False)]
)
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


def test_the_price_is_that_of_the_largest_friction_of_the_run(loop):
    """v_u1 - (mu m g + dbar)/(M_min alpha), mu and m those of the change that brakes most."""
    changes = [{"t": 5.0, "mu": 0.3}, {"t": 9.0, "mu": 0.1, "m": 55.0}]
    numbers = {**ON, "guard.M_min": [25.0, 2.7], "guard.dbar": [60.0, 10.0], "changes": changes}
    of = loop("prox", numbers)
    friction = 0.3 * of.scenario.robot.m * of.scenario.robot.g

    assert slowest(of) == pytest.approx(1 - (friction + 60) / (25 * 100), rel=1e-9)


def test_a_robot_that_cannot_move_is_told(told):
    slow = {**ON, "guard.M_min": [25.0, 2.7], "guard.dbar": [60.0, 10.0], "guard.alpha": 5.0}
    narrow = {**slow, "disturbance.std": 0.0, "robot.mu": 0.15}
    (found,) = told("mb", narrow, key="guard.dbar")

    assert "no motion at all" in found.sentence


@pytest.mark.parametrize("scenario", ["safe-simulation", "safe-experiment"])
def test_our_presets_leave_enough(told, scenario):
    assert told("prox", scenario=scenario, key="guard.dbar") == []
