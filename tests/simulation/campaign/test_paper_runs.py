"""Which runs are planned."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

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


AS_STATED = [one.label for one in STUDIES if one.label.startswith("as-stated")]


@pytest.mark.parametrize("name", AS_STATED)
def test_the_theorems_own_case_has_neither_noise_nor_a_wrong_model_nor_a_start_outside(name):
    study = next(one for one in STUDIES if one.label == name)
    scenario = load_scenario(study.scenario, study.overrides)

    assert scenario.disturbance.std == 0
    assert scenario.changes == ()
    assert scenario.believed.m == scenario.robot.m
    assert scenario.believed.mu == scenario.robot.mu
    assert scenario.clock.control <= 1e-4
    assert all(
        abs(v) < limit
        for v, limit in zip(scenario.initial.velocity, scenario.limits.v_u1, strict=True)
    )


@given(seeds=st.integers(1, 30), first=st.integers(0, 100))
def test_each_run_is_planned_once_with_seeds_in_a_row(seeds, first):
    plan = paper_plan(seeds=seeds, first_seed=first)

    assert len(set(plan)) == len(plan)
    assert {task.seed for task in plan} == set(range(first, first + seeds))
    assert {case.law for case, _ in plan} == set(PAPER_LAWS)


@given(seeds=st.integers(1, 30))
def test_studies_take_all_seeds_or_as_many_as_they_need(seeds):
    plan = paper_plan(seeds=seeds)
    for study in STUDIES:
        taken = {task.seed for task in plan if task.case.name == study.label}

        assert taken == set(range(min(seeds, study.seeds)))


@pytest.mark.parametrize("wrong", [{"seeds": 0}, {"first_seed": -1}, {"laws": ["mb", "mb"]}])
def test_impossible_plans_are_refused(wrong):
    with pytest.raises(ArgumentError):
        paper_plan(**wrong)
