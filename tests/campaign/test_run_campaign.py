"""Running a plan: its order, what it keeps, how it ends when it fails or is interrupted."""

from __future__ import annotations

import pytest

from tests.campaign.synthetic import Watch, in_turn, prepared
from wmr_ctrl.campaign import PlannedRun, paper_plan, run_campaign
from wmr_ctrl.errors import ArgumentError

PLAN = [PlannedRun("paper-simulation", law, seed) for seed in (4, 3, 5) for law in ("mb", "nn")]


def test_rows_stand_in_the_order_of_the_plan(fake_simulate):
    table = run_campaign(in_turn, prepared(fake_simulate), PLAN).table

    assert [PlannedRun(row.scenario, row.law, row.seed) for row in table] == PLAN


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
