"""Plans: their points, cases and seeds."""

import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.simulation.campaign.plan import PlannedCase, SamplePlan, Study

RANGES = {"robot.mu": (0.1, 0.3), "robot.m": (40.0, 60.0)}


@pytest.mark.parametrize("method", ["uniform", "latin-hypercube"])
def test_a_sample_is_within_its_box_and_the_same_for_a_seed(method):
    points = SamplePlan(method, 50, 3, RANGES).points

    assert (points >= [0.1, 40.0]).all()
    assert (points <= [0.3, 60.0]).all()
    assert np.array_equal(points, SamplePlan(method, 50, 3, RANGES).points)
    strata = np.floor((points[:, 0] - 0.1) / 0.2 * 50)
    assert (len(set(strata)) == 50) is (method == "latin-hypercube")


def test_a_study_counts_its_points_laws_guards_and_seeds():
    grid = {"robot.mu": (0.1, 0.2), "robot.m": (40.0, 50.0, 60.0)}
    study = Study("far-start", seeds=4, laws=("pid", "mb"), guards=(True, False), grid=grid)

    assert (study.points, study.cells, study.runs) == (6, 24, 96)
    assert study.combinations[1] == (0.1, 50.0)
    assert study.label == "far-start"
    planned = list(study.planned(["mb", "nn"], range(9)))
    assert len(planned) == 6 * 2 * 4
    assert {run.case.law for run in planned} == {"mb"}


def test_a_case_overrides_its_scenario_and_switches_the_guard():
    case = PlannedCase(paper(), "mb", True, {"disturbance.truncate": 3.0}, name="x")

    assert case.overridden().guard.enabled
    assert case.labels["case"] == "x"
    assert PlannedCase(paper(), "mb").overridden() == paper()
