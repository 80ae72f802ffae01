"""Running a plan: its order, what it keeps, how it ends when it fails or is interrupted."""

from __future__ import annotations

import pytest

from tests.campaign.synthetic import Watch, in_turn, prepared
from wmr_ctrl.campaign import PlannedRun, Study, paper_plan, run_campaign
from wmr_ctrl.errors import ArgumentError

STUDY = Study("paper-simulation")
PLAN = [PlannedRun(STUDY, law, seed) for seed in (4, 3, 5) for law in ("mb", "nn")]


def test_rows_stand_in_the_order_of_the_plan(fake_simulate):
    table = run_campaign(in_turn, prepared(fake_simulate), PLAN).table

    assert [(row.scenario, row.law, row.seed) for row in table] == [
        (task.scenario, task.law, task.seed) for task in PLAN
    ]


def test_a_study_that_changes_fields_has_its_own_name_and_rows(fake_simulate):
    asked = []

    def prepare(scenario, law, overrides=None, guard=None):
        asked.append((scenario, overrides))
        return lambda seed: fake_simulate(scenario, law, seed)

    own = Study("paper-simulation", 1, "mine", "title", overrides={"clock.control": 0.001})
    done = run_campaign(in_turn, prepare, [PlannedRun(STUDY, "mb", 0), PlannedRun(own, "mb", 0)])

    assert done.table.scenarios == ("paper-simulation", "mine")
    assert set(done.runs) == {("paper-simulation", "mb"), ("mine", "mb")}
    assert asked == [("paper-simulation", {}), ("paper-simulation", {"clock.control": 0.001})]


def test_only_the_first_seed_of_a_case_is_kept_whole(fake_simulate):
    runs = run_campaign(in_turn, prepared(fake_simulate), PLAN).runs

    assert {case: run.seed for case, run in runs.items()} == {
        ("paper-simulation", "mb"): 3,
        ("paper-simulation", "nn"): 3,
    }


def test_every_case_is_compiled_once_before_the_first_run(fake_simulate):
    calls = []

    def prepare(scenario, law, overrides=None, guard=None):
        calls.append((scenario, law))

        def loop(seed):
            calls.append("run")
            return fake_simulate(scenario, law, seed)

        return loop

    run_campaign(in_turn, prepare, PLAN)

    assert calls == [("paper-simulation", "mb"), ("paper-simulation", "nn"), *["run"] * 6]


def test_progress_counts_every_step_of_every_phase(fake_simulate):
    watch = Watch()
    run_campaign(in_turn, prepared(fake_simulate), PLAN, progress=watch)

    assert watch.totals == [2, 6]
    assert watch.left == [0, 0]
    assert watch.ended == 2


@pytest.mark.parametrize("error", [RuntimeError("no"), KeyboardInterrupt()])
def test_a_failure_ends_the_campaign_and_its_progress(fake_simulate, error):
    begun, watch = [], Watch()

    def simulate(scenario, law, seed):
        begun.append(seed)
        if len(begun) == 2:
            raise error
        return fake_simulate(scenario, law, seed)

    with pytest.raises(type(error)):
        run_campaign(in_turn, prepared(simulate), paper_plan(seeds=20), progress=watch)
    assert len(begun) == 2
    assert watch.ended == 2


@pytest.mark.parametrize("wrong", [{"jobs": 0}, {"plan": []}])
def test_impossible_campaigns_are_refused(fake_simulate, wrong):
    with pytest.raises(ArgumentError):
        run_campaign(in_turn, prepared(fake_simulate), **{"plan": PLAN, **wrong})
