"""Bounds of the guard at their ends: a proposed value is accepted, a slightly smaller one not."""

import numpy as np
import pytest

from tests.control.guard.parameters import feasible_with
from tests.control.guard.test_contradictions import BROKEN, MET
from tests.tables import changes
from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.guard.bounds import derived_guard
from wmr_ctrl.control.guard.contradictions import beyond_belief, contradictions
from wmr_ctrl.control.guard.price import usable_speed
from wmr_ctrl.control.guard.refusals import feasible_guard
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.scenario import load_scenario, override

ON = {"guard.enabled": True, "disturbance.std": 0.0, "changes": []}


def guarded(**changed):
    return load_scenario("paper-simulation", {**ON, **changed})


def test_each_bound_that_is_broken_is_named_and_none_that_is_met():
    base = override(load_scenario("safe-simulation"), {"guard.enabled": False})
    for case in (*BROKEN, *MET):
        stated = changes(case.values[0])
        scenario = override(base, stated)
        named = [item.key for item in contradictions(scenario, settle(scenario, "prox").bound)]
        assert named == [*stated][: case in BROKEN], stated


@pytest.mark.parametrize("spread, key", [
    (0.9, None), (1.1, "guard.M_min"), (14.9, "guard.M_min"), (0.0, None),
])  # fmt: skip
def test_what_effects_add_to_the_robots_mass_must_be_counted_too(spread, key):
    scenario = guarded(**{"guard.M_min": [49.0, 5.0], "guard.M_max": [70.0, 7.0]})
    setup = settle(scenario, None)

    found = beyond_belief(scenario, setup.guard, Bound(mass=(spread, 0.0)))

    assert [item.key for item in found] == ([key] if key else [])


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_spare_torque_is_shared_between_braking_ahead_and_in_a_turn(share):
    pushed = {"guard.dbar": [60.0, 15.0], "guard.brake_share": share, "actuator.tau_max": 10.0}
    brake = settle(guarded(**pushed), None).guard.brake
    phi, half_track = 2 * 10.0 / 0.1, 0.25
    spare = phi - 60.0 - 15.0 / half_track

    assert brake[0] == pytest.approx(60.0 + share * spare)
    assert brake[1] == pytest.approx(15.0 + (1 - share) * spare * half_track)


def test_a_derived_brake_is_within_the_wheels_reach_however_it_is_rounded():
    pushed = guarded(**{"guard.dbar": [60.0, 15.0]})
    for tau_max, share in np.random.default_rng(0).uniform((7.0, 0.05), (20.0, 0.95), (60, 2)):
        scenario = override(
            pushed, {"guard.brake_share": share, "robot.r": tau_max / 140, "robot.l": 0.23}
        )
        first, second = feasible_guard(scenario, Bound(), tau_max).brake
        assert first + second / scenario.robot.l <= 2 * tau_max / scenario.robot.r


def test_where_the_robot_would_not_start_no_speed_is_usable():
    """A mean over a long window hides the robot's speed; at rest the whole window counts."""
    scenario = guarded(**{"guard.dbar": [60.0, 15.0]})
    late = Bound(window=(0.5, 0.5))
    numbers = derived_guard(scenario, late, np.inf)
    M, T, f_speed = numbers.M_min[0], 0.01, 0.0
    for friction, starts in ((20.0, True), (30.0, False)):
        force = friction + 60.0
        mean = 1.0 - force * (T + 0.25) / M
        rest = 1.0 - f_speed - force * (T + 0.5) / M
        assert (rest >= 0) is starts
        expected = mean if starts else min(mean, rest)
        assert usable_speed(scenario, numbers, (friction, 0.0))[0] == pytest.approx(
            expected, abs=1e-9
        )


@pytest.mark.parametrize("kind", ["linear-first", "rotation-first"])
def test_brakes_beyond_the_wheels_by_a_rounding_are_not_feasible(kind):
    """Otherwise the force would be too small in every sample, and the limit would be exceeded again
    and again.
    """
    edge = changes("guard.dbar = [60, 15]; guard.brake = [100, 25]; actuator.tau_max = 10")
    item = guard(settle(guarded(**edge, **{"guard.map": kind}), None))

    assert feasible_with(item, {}) == 1.0
    assert feasible_with(item, {"guard.brake[2]": 1 + 2.0**-51}) == 0.0
