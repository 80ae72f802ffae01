"""The plane model beside the rigid body: which runs are made, and what is kept of them."""

from __future__ import annotations

import math

import pytest

from tests.campaign.synthetic import made_up as made_up_runs
from wmr_ctrl.campaign.rigid import (
    LIMITED,
    RIGID_CASES,
    RigidComparison,
    RigidRow,
    run_rigid_comparison,
)
from wmr_ctrl.campaign.rigid_claims import rigid_claims
from wmr_ctrl.control.setup import settle
from wmr_ctrl.scenario import load_scenario


@pytest.mark.parametrize("case", RIGID_CASES, ids=lambda case: case.name)
def test_cases_are_what_a_scenario_and_a_guard_take(case):
    for plant in ("ode", "mujoco"):
        for law in case.laws:
            planned = case.planned(law, plant)
            guard = {} if case.guard is None else {"guard.enabled": case.guard}
            settle(load_scenario(planned.scenario, {**planned.overrides, **guard}), law)


def test_a_slope_is_as_steep_and_rises_the_same_way_on_both():
    case = next(one for one in RIGID_CASES if "slope" in one.name)
    plane, body = (
        load_scenario(case.preset, case.planned("mb", plant).overrides)
        for plant in ("ode", "mujoco")
    )

    assert plane.effects["slope"].angle == body.body.slope == pytest.approx(math.radians(5))
    assert plane.effects["slope"].direction == body.body.uphill + math.pi / 2


def test_every_case_law_and_seed_is_run_on_both():
    with made_up_runs():
        done = run_rigid_comparison(seeds=(4, 5))
    laws = sum(len(case.laws) for case in RIGID_CASES)

    assert len(done.rows) == 2 * 2 * laws
    assert len(done.runs) == 2 * laws
    assert all(run.seed == 4 for run in done.runs.values())
    first = RIGID_CASES[0]
    assert [row.seed for row in done.of(first.name, first.laws[0], "mujoco")] == [4, 5]


def made_up(plant, seed, **values):
    row = {"outcome": "completed", "ise": 1.0, "e1_before": 0.001, "e1": 0.012, "ratio": 0.9}
    return RigidRow(
        LIMITED, "mb", seed, plant, **{**row, "slipped": None, "tipped": None, **values}
    )


def verdicts(*rows):
    return {claim.text: claim for claim in rigid_claims(RigidComparison(rows))}


def test_claims_are_judged_on_every_seed():
    plane = [made_up("ode", seed) for seed in (0, 1)]
    good = verdicts(*plane, made_up("mujoco", 0, ise=1.04), made_up("mujoco", 1, ise=0.99))
    same, growth = "With 10 N m the ISE is within 5 %", "After the change e₁ is more than 10 times"
    alike = next(claim for text, claim in good.items() if text.startswith(same))
    grown = next(claim for text, claim in good.items() if text.startswith(growth))

    assert (alike.holds, alike.numbers, alike.law) == (True, "1 to 4 %", "mb")
    assert (grown.holds, grown.numbers) == (True, "12")
    assert not any("slope" in text or "nn" in claim.law for text, claim in good.items())

    one_bad = verdicts(*plane, made_up("mujoco", 0), made_up("mujoco", 1, ise=1.06))
    alike = next(claim for text, claim in one_bad.items() if text.startswith(same))
    assert (alike.holds, alike.numbers) == (False, "0 to 6 %")


def test_a_run_without_the_number_is_no_evidence():
    fell = made_up("mujoco", 0, ise=None, e1=None, e1_before=None, tipped=4.0)
    found = verdicts(made_up("ode", 0), fell)

    assert not any(claim.holds for claim in found.values())
    assert {claim.numbers for claim in found.values()} == {"none in 1 runs"}
