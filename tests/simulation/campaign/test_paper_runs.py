"""Which runs are planned."""

import numpy as np
import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.simulation.campaign import PAPER_LAWS
from wmr_ctrl.simulation.campaign.paper_runs import STUDIES, paper_plan
from wmr_ctrl.world.scenario import load_scenario, preset_names


def test_every_study_is_a_preset_or_changes_one_under_a_name_of_its_own():
    assert {study.scenario for study in STUDIES} <= set(preset_names())
    assert len({study.label for study in STUDIES}) == len(STUDIES)
    for study in STUDIES:
        load_scenario(study.scenario, study.overrides)
        assert bool(study.overrides) == bool(study.name) == bool(study.title)
        assert not study.name or study.name not in preset_names()


def test_the_theorems_own_case_has_neither_noise_nor_a_wrong_model_nor_a_start_outside():
    for study in (one for one in STUDIES if one.label.startswith("as-stated")):
        scenario = load_scenario(study.scenario, study.overrides)
        told, robot = scenario.believed, scenario.robot

        assert (scenario.disturbance.std, scenario.changes) == (0, ())
        assert (told.m, told.mu) == (robot.m, robot.mu)
        assert scenario.clock.control <= 1e-4
        assert (np.abs(scenario.initial.velocity) < scenario.limits.v_u1).all()


@pytest.mark.parametrize("seeds, first", [(1, 0), (7, 100), (30, 3)])
def test_each_run_is_planned_once_with_as_many_seeds_in_a_row_as_its_study_needs(seeds, first):
    plan = paper_plan(seeds=seeds, first_seed=first)

    assert len(set(plan)) == len(plan)
    assert {case.law for case, _ in plan} == set(PAPER_LAWS)
    for study in STUDIES:
        taken = {task.seed for task in plan if task.case.name == study.label}
        assert taken == set(range(first, first + min(seeds, study.seeds)))


@pytest.mark.parametrize("wrong", [{"seeds": 0}, {"first_seed": -1}, {"laws": ["mb", "mb"]}])
def test_impossible_plans_are_refused(wrong):
    with pytest.raises(ArgumentError):
        paper_plan(**wrong)
