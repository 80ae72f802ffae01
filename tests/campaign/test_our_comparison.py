"""The comparison with and without the guard: its plan, its rows, and what it finds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from wmr_ctrl.api import compile_loop, scenario_of
from wmr_ctrl.campaign.ours import FACTORS, HELD_OUT, OUR_LAWS, our_plan
from wmr_ctrl.campaign.ours_cases import run_ours
from wmr_ctrl.campaign.ours_run import Comparison
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.sim.ready import Ready
from wmr_ctrl.sim.together import run_each


def short(scenario: str, law: str, guard: bool, overrides: Mapping[str, Any]) -> Ready:
    shorter = {**overrides, "clock.duration": 10.0}
    changes = [change for change in overrides.get("changes", []) if change["t"] < 10.0]
    return compile_loop(scenario_of(scenario, {**shorter, "changes": changes}, guard), law)


def test_plan_has_every_case_once() -> None:
    plan = our_plan()
    keys = {(c.base, c.factor, c.law, c.guard, c.seed) for c in plan}

    assert len(keys) == len(plan)
    assert {c.law for c in plan} == set(OUR_LAWS)
    assert {c.factor for c in plan} == set(FACTORS)
    assert {c.seed for c in plan} == set(HELD_OUT)


@pytest.fixture(scope="module")
def rows() -> tuple[Comparison, ...]:
    return run_ours(run_each, short, our_plan(seeds=HELD_OUT[:1]))


def test_guarded_runs_from_inside_keep_the_limits(rows: tuple[Comparison, ...]) -> None:
    guarded = [r for r in rows if r.case.guard and r.case.factor != "start outside"]

    assert {r.outcome for r in guarded} == {"completed", "refused"}
    assert all(r.violations == 0 for r in guarded)


def test_only_the_torque_limit_that_is_too_low_is_refused(rows: tuple[Comparison, ...]) -> None:
    refused = {r.case.factor for r in rows if r.outcome == "refused"}

    assert refused == {"tau_max = 5 N m"}


def test_without_the_guard_limits_break(rows: tuple[Comparison, ...]) -> None:
    broken = {r.case.law for r in rows if not r.case.guard and r.violations}

    assert broken == set(OUR_LAWS)


def test_result_does_not_depend_on_the_number_of_threads(rows: tuple[Comparison, ...]) -> None:
    few = [c for c in our_plan(seeds=HELD_OUT[:1]) if c.law == "mb" and c.base == "10 ms"]
    alone = run_ours(run_each, short, few, jobs=1)

    assert alone == tuple(r for r in rows if r.case in few)


def test_unguarded_errors_are_not_swallowed() -> None:
    def refusing(*_: object) -> Ready:
        raise ScenarioError("no")

    plan = [c for c in our_plan(seeds=(0,)) if not c.guard][:1]
    with pytest.raises(ScenarioError):
        run_ours(run_each, refusing, plan)


def test_share_in_clip_is_told_of_guarded_runs_alone(rows: tuple[Comparison, ...]) -> None:
    assert all((r.clipped is None) == (not r.case.guard or r.outcome == "refused") for r in rows)
