"""Late and filtered poses in the linear loop: what it says is what runs do."""

import pytest

from wmr_ctrl.api import simulate
from wmr_ctrl.theory.checks.stable_ranges import largest_stable_period
from wmr_ctrl.theory.checks.surroundings import lost_samples, rare_poses
from wmr_ctrl.world.scenario import load_scenario


@pytest.mark.slow
def test_runs_cycle_where_a_pose_is_said_to_be_too_old():
    for age, stable in ((0.1, True), (0.2, False)):
        scenario = load_scenario("paper-simulation-nominal", {"sensor.pose_delay": age})
        remarks = [item.key for item in simulate(scenario, "prox").remarks]

        assert (largest_stable_period(scenario, "prox") > 0.01) is stable
        assert ("oscillates" not in remarks) is stable


def test_what_is_left_out_is_said():
    rare = {"sensor.pose_period": 0.1, "sensor.pose_dropout": 0.3}

    assert rare_poses(load_scenario("paper-simulation")) == ""
    assert lost_samples(load_scenario("paper-simulation")) == ""
    assert lost_samples(load_scenario("paper-simulation", rare)) == (
        "as if nothing were lost, though 30% of the poses may be"
    )
    assert rare_poses(load_scenario("paper-simulation", rare)) == (
        "as if a pose came at every sample, though one comes every 0.1 s"
    )
