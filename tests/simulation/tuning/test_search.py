"""The search alone: its candidates, the best so far, and refused plans."""

import math

import numpy as np
import pytest

from wmr_ctrl import tune
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.simulation.tuning import gains
from wmr_ctrl.simulation.tuning.search import Cost, Search, TuningPlan
from wmr_ctrl.world.scenario import load_scenario

START = {"gains.mb.rho": (60.0, 20.0)}


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("safe-simulation", START)


def test_it_begins_with_the_start_and_goes_no_farther_than_thirty_times():
    """However small the cost farther away is."""
    search, most = Search({"a": (1.0,), "b": (2.0, 3.0)}), 0.0
    for generation in range(40):
        asked = search.ask()
        assert generation or not asked[0].any()
        search.tell(asked, [Cost(False, 0, -float(item.sum())) for item in asked])
        most = max(most, np.abs(asked).max())

    assert 29.0 < math.exp(most) < 30.0


@pytest.mark.parametrize("wrong", [{"trials": 0}, {"weight": -1e-9}, {"weight": math.inf}])
def test_a_plan_has_a_trial_and_a_finite_weight_of_zero_or_more(scenario, wrong):
    least = {"trials": 1, "weight": 0.0}

    assert TuningPlan(scenario=scenario, law="mb", **least).weight == 0.0
    with pytest.raises(ArgumentError, match=next(iter(wrong))):
        TuningPlan(scenario=scenario, law="mb", **(least | wrong))


def test_gains_that_are_worse_at_last_are_not_taken(scenario, monkeypatch, tmp_path):
    """The search finds a set with a lower cost, which turns out higher when both are run at the
    end.
    """
    calls = []

    def costs(plan, sets, jobs):
        calls.append(sets)
        last = len(calls) == 2
        return [Cost(False, 0, float(k + 1 if last else 9 - k)) for k in range(len(sets))]

    monkeypatch.setattr(gains, "_costs", costs)
    monkeypatch.setattr(gains, "judged", lambda *_: None)
    found = tune(scenario, "mb", tmp_path / "a.toml", seeds=[1], test_seeds=[2], trials=1)

    assert calls[1][1]["gains.mb.rho"] != START["gains.mb.rho"]
    assert found.gains["gains.mb.rho"] == START["gains.mb.rho"]
    assert found.objective == (Cost(False, 0, 1.0), Cost(False, 0, 1.0))
