"""Corridors with rare or lost poses and dead reckoning between them."""

import re

import numpy as np
import pytest

from benchmarks.corridor_adversary import worst_errors, worst_pushes
from tests.corridor.further import farthest_lost, lossy, simulated
from tests.tables import changes
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.theory.corridor import corridor_monitor, find_corridor
from wmr_proofs.corridor import asked, reckoning

SAMPLES = 200
NOISY = changes("disturbance.std = 0.0; sensor.velocity_noise = [1e-3, 4e-3]")


@pytest.mark.slow
def test_pushes_do_not_drive_it_out_whatever_poses_are_lost_up_to_the_bound():
    scenario, exact = simulated(lossy(1)), simulated()
    tube, rng = find_corridor(scenario, "prox"), np.random.default_rng(2)
    pushes = worst_pushes(exact, "prox", SAMPLES, 0.3)
    every_second = np.arange(SAMPLES) % 2 == 1
    always = farthest_lost(scenario, pushes, [0, 1])
    some = farthest_lost(scenario, pushes[:2], (rng.random(SAMPLES) < 0.4) | every_second)
    beyond = farthest_lost(scenario, [1.2 * push for push in pushes], [0, 1])

    assert tube.position / 1.2 <= max(always[0], some[0]) <= tube.position
    assert max(always[1], some[1]) <= tube.heading
    assert beyond[0] > tube.position
    assert "no pose comes to up to 1 samples in a row" in tube.sentence


@pytest.mark.slow
def test_over_any_number_of_samples_more_than_are_summed_up_cost_no_less():
    """Sums of more samples than the table's rows are composed of those rows."""
    corridors = [find_corridor(simulated(lossy(times)), "prox").position for times in (5, 9, 12)]
    kept = reckoning.MOST_ROW_SAMPLES
    reckoning.MOST_ROW_SAMPLES = 5
    try:
        asked._found.cache_clear()
        apart = [find_corridor(simulated(lossy(times)), "prox").position for times in (5, 9, 12)]
    finally:
        reckoning.MOST_ROW_SAMPLES = kept
        asked._found.cache_clear()

    assert corridors[0] == apart[0]
    assert corridors[0] < corridors[1] < corridors[2]
    assert all(one < two < 1.3 * one for one, two in zip(corridors[1:], apart[1:], strict=True))


@pytest.mark.slow
def test_errors_of_velocities_add_up_while_poses_are_lost_and_beyond_the_bound_they_leave_it():
    scenario = simulated(NOISY, lossy(4))
    tube, size = find_corridor(scenario, "prox"), np.array(scenario.sensor.velocity_noise)
    still = np.zeros((SAMPLES, 2))
    each = [np.vstack([x, x])[:SAMPLES] for x in
            worst_errors(simulated(NOISY), "prox", SAMPLES, "velocity", size)]  # fmt: skip
    each += [np.tile(signs * size, (SAMPLES, 1)) for signs in np.array([[1, 1], [1, -1]])]
    within = farthest_lost(scenario, [still] * len(each), [0, 0, 0, 0, 1], each)
    longer = farthest_lost(scenario, [still] * len(each), [*[0] * 39, 1], each)

    assert tube.position / 4 < within[0] <= tube.position < longer[0]
    assert within[1] <= tube.heading


@pytest.mark.slow
def test_a_pose_every_few_samples_is_as_many_that_are_lost():
    rare, lost = simulated("sensor.pose_period = 0.03"), simulated(lossy(2))
    tube = find_corridor(rare, "prox")
    reached = farthest_lost(rare, worst_pushes(simulated(), "prox", SAMPLES, 0.3)[::3], [1])

    assert tube.position == find_corridor(lost, "prox").position
    assert tube.position / 1.2 <= reached[0] <= tube.position


@pytest.mark.slow
def test_where_hardly_any_pose_comes_it_is_refused():
    refused = find_corridor(simulated(NOISY, "sensor.pose_period = 1000.0"), "prox").refused

    assert re.search("for 99999 samples may grow by itself", refused)


@pytest.mark.parametrize(
    "changes, why",
    [
        ({"sensor.pose_dropout": 0.1}, "state corridor.losses"),
        (changes("sensor.pose_period = 0.05; sensor.correction = 0.5"), "corrected in part"),
        (changes("sensor.pose_period = 0.05; reference.kind = lemniscate"), "over a whole run"),
    ],
)
def test_what_is_not_covered_is_refused_by_name(changes, why):
    assert why in find_corridor(simulated(changes), "prox", whole=True).refused


@pytest.mark.slow
def test_a_monitor_does_not_see_whether_poses_come():
    with pytest.raises(ScenarioError, match="rare or partly corrected poses"):
        corridor_monitor(simulated(lossy(1)), "prox")
