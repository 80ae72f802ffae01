"""Each bound that a corridor counts on matters: a fifth beyond it, some adversary leaves.

Errors of measurements are in `test_certificate`, beside what they reach within their bounds.
"""

import pytest

from tests.corridor.adversary import farthest, farthest_displaced
from tests.corridor.further import reckoned_for_long
from wmr_ctrl.theory.corridor import find_corridor
from wmr_ctrl.world.scenario import load_scenario, override


@pytest.mark.slow
def test_a_push_a_fifth_beyond_its_bound_leaves_the_corridor():
    scenario = load_scenario("safe-simulation")
    tube = find_corridor(scenario, "prox")

    assert farthest(scenario, "prox", 300, 3.0, times=1.2).position > tube.position


@pytest.mark.slow
def test_a_mass_a_fifth_beyond_its_interval_leaves_it_and_none_within():
    """Pushes are small, so that what the law believes of the mass is what counts."""
    told = {
        "guard.M_min": [60.0, 6.0], "guard.M_max": [65.0, 7.0], "corridor.cells": 2,
        "disturbance.std": 0.05, "changes": [], "robot.m": 62.0, "robot.I": 6.5,
        "model.m": 50.0, "model.I": 5.4, "model.mu": 0.08,
    }  # fmt: skip
    scenario = override(load_scenario("safe-simulation"), told)
    tube = find_corridor(scenario, "prox")

    def reached(mass, inertia):
        heavy = override(scenario, {"robot.m": mass, "robot.I": inertia, "corridor.cells": 0})
        return farthest(heavy, "prox", 200, 0.15).position

    assert reached(65.0, 7.0) <= tube.position < reached(1.2 * 65.0, 1.2 * 7.0)


@pytest.mark.slow
def test_a_start_a_fifth_beyond_what_is_named_leaves_it_and_none_within():
    alone = {"corridor.start": [1e-3, 1e-3, 5e-3], "disturbance.std": 0.0}
    scenario = override(load_scenario("safe-simulation"), alone)
    tube = find_corridor(scenario, "prox")
    within, beyond = (
        farthest_displaced(scenario, "prox", 100, times).position for times in (1.0, 1.2)
    )

    assert tube.position / 1.1 < within <= tube.position < beyond


@pytest.mark.slow
def test_a_fifth_more_lost_poses_than_are_stated_leave_it_and_as_many_do_not():
    case = reckoned_for_long(300)
    tube = find_corridor(case.scenario, case.law)

    assert case.reach(1.0) <= tube.position < case.reach(1.2)
