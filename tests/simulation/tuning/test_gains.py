"""Runs that tuning makes, and its result; the tests supply made-up runs."""

import math
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import numpy as np
import pytest

from tests.papers_robot import safe
from wmr_ctrl import tune
from wmr_ctrl.results.table import RunTable
from wmr_ctrl.simulation.tuning import gains, judged
from wmr_ctrl.simulation.tuning.search import Cost, TuningPlan
from wmr_ctrl.world.scenario import Model

TOLD = """
robot.m = 55.0; robot.I = 6.0; model.m = 50.0; model.I = 5.0; model.mu = 0.07
gains.mb.rho = [60.0, 20.0]
"""
NAMES = ("tracking_drive_rms", "torque_change_rms", "max_abs_v1", "max_abs_v2")


@pytest.fixture
def guarded():
    return safe(TOLD)


@pytest.fixture
def runs(monkeypatch):
    """Cases and seeds of all runs; their figures are their numbers, each run's squared."""
    asked = SimpleNamespace(cases=[], seeds=[], stop={})

    def table_of(plant, cases, law, seeds, **_):
        numbers = np.arange(len(cases)) + len(asked.cases)
        asked.cases += cases
        asked.seeds += seeds
        stop = np.array([asked.stop.get(k, 0) for k in numbers.tolist()])
        columns = {name: (place + 1.0) * (numbers + 1.0) ** 2 for place, name in enumerate(NAMES)}
        return RunTable({**columns, "stop": stop})

    monkeypatch.setattr(gains, "table_of", table_of)
    return asked


@pytest.mark.parametrize("stated", [True, False])
def test_the_cost_is_of_three_robots_without_guard_that_believe_what_the_scenario_does(
    guarded, runs, stated
):
    """If no model is stated, the model is the robot."""
    if not stated:
        guarded = replace(guarded, model=Model(mu=0.07))
    m, inertia = (50.0, 5.0) if stated else (55.0, 6.0)
    plan = TuningPlan(scenario=guarded, law="mb", seeds=(4, 5), test_seeds=(7,), weight=0.1)
    own = {"gains.mb.rho": (60.0, 20.0)}
    runs.stop = {8: 2}
    costs = gains._costs(plan, [own, {"gains.mb.rho": (30.0, 20.0)}], None)

    squares = [(k + 1) ** 4 * (1 + (0.1 * 2) ** 2) for k in range(12)]
    kept = [*squares[6:8], *squares[9:]]
    assert costs[0] == Cost(False, 0, pytest.approx(math.sqrt(np.mean(squares[:6]))))
    assert costs[1] == Cost(False, 1, pytest.approx(math.sqrt(np.mean(kept))))
    assert runs.seeds == [4, 5] * 6
    assert [case.gains["mb"]["rho"][0] for case in runs.cases] == [60.0] * 6 + [30.0] * 6
    bodies = [(case.robot.m, case.robot.I) for case in runs.cases[:6:2]]
    assert bodies == [(55.0, 6.0), (0.6 * m, 0.6 * inertia), (1.6 * m, 1.6 * inertia)]
    for case in runs.cases:
        assert not case.guard.enabled
        assert (case.believed.m, case.believed.I, case.believed.mu) == (m, inertia, 0.07)
        assert case.changes == (guarded.changes if case.robot.m == 55.0 else ())


def test_the_test_tells_medians_and_greatest_speeds_of_each_reference_and_robot(guarded, runs):
    runs.stop = {3: 1, 5: 4}
    table = judged(guarded, "mb", [7, 8, 9])

    assert runs.seeds == [7, 8, 9] * 9
    assert table["reference"].tolist() == ["circle"] * 3 + ["lemniscate"] * 3 + ["line"] * 3
    assert [case.reference_kind.name for case in runs.cases[::3]] == table["reference"].tolist()
    assert table["mass"].tolist() == [1.0, 0.6, 1.6] * 3
    assert table["lost"].tolist() == [0, 2] + [0] * 7
    middle, last = (np.arange(k, 28, 3) ** 2 for k in (2, 3))
    for place, (name, of) in enumerate(zip(NAMES, (middle, middle, last, last), strict=True)):
        assert table[name].tolist() == ((place + 1.0) * of).tolist()


def test_what_was_found_is_told_in_order(guarded, monkeypatch, tmp_path):
    """Runs cost less from call to call, and a corridor is as wide as the gain is large."""
    calls = count()

    def table_of(plant, cases, *_, **__):
        size = np.array([case.gains["mb"]["rho"][0] for case in cases]) / (1 + next(calls))
        return RunTable({**dict.fromkeys(NAMES, 0.001 * size), "stop": 0 * size})

    def corridor(scenario, law):
        size = 1e-3 * scenario.gains["mb"]["rho"][0]
        return SimpleNamespace(merit=(False, size), position=size, linear=size)

    monkeypatch.setattr(gains, "table_of", table_of)
    monkeypatch.setattr(gains, "certified_corridor", corridor)
    monkeypatch.setattr(gains, "find_corridor", corridor)
    monkeypatch.setattr(gains, "proofs", lambda: None)
    told = {"seeds": [1], "test_seeds": [2], "trials": 12, "merit": "corridor"}
    found = tune(guarded, "mb", tmp_path / "a.toml", **told)
    first, last = (cost.sentence for cost in found.objective)

    assert found.objective[1] < found.objective[0]
    assert found.corridor == (0.06, pytest.approx(1e-3 * found.gains["gains.mb.rho"][0]))
    assert f"{first} before, {last} after" in found.out.read_text()
    assert found.objective[0].metres == pytest.approx(0.06, rel=1e-3)
