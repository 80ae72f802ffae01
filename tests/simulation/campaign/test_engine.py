"""Running a plan: its order, the rows that it keeps, and its end on failure or interruption."""

import pytest

from tests.simulation.campaign.synthetic import made_up, simulate
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.simulation.campaign.engine import run_campaign
from wmr_ctrl.simulation.campaign.paper_runs import paper_plan
from wmr_ctrl.simulation.campaign.plan import Study

STUDY = Study("paper-simulation")
PLAN = [run for seed in (4, 3, 5) for run in STUDY.planned(("mb", "nn"), [seed])]


def test_rows_stand_in_the_order_of_the_plan_and_each_case_is_compiled_once_before_all_runs():
    calls = []

    def counted(scenario, law, seed):
        calls.append("run")
        return simulate(scenario, law, seed)

    with made_up(counted, lambda case: calls.append((case.scenario, case.law))):
        table = run_campaign(PLAN).table

    planned = [{**case.labels, "seed": seed} for case, seed in PLAN]
    assert [{name: row[name] for name in planned[0]} for row in table.records()] == planned
    assert calls == [("paper-simulation", "mb"), ("paper-simulation", "nn"), *["run"] * 6]


@pytest.mark.parametrize("error", [RuntimeError("no"), KeyboardInterrupt()])
def test_a_failure_ends_the_campaign(error):
    begun = []

    def failing(scenario, law, seed):
        begun.append(seed)
        if len(begun) == 2:
            raise error
        return simulate(scenario, law, seed)

    with made_up(failing), pytest.raises(type(error)):
        run_campaign(paper_plan(seeds=20))
    assert len(begun) == 2


@pytest.mark.parametrize("wrong", [{"jobs": 0}, {"plan": []}])
def test_impossible_campaigns_are_refused(wrong):
    with made_up(), pytest.raises(ArgumentError):
        run_campaign(**{"plan": PLAN, **wrong})
