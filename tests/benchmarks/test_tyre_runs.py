"""Plane model and rigid body: which runs are made, and which figures are kept."""

import math

import pytest

from benchmarks.tyre_runs import (
    E1,
    E1_BEFORE,
    RIGID_STUDIES,
    SLOPED,
    rigid_claims,
    run_rigid_comparison,
)
from tests.simulation.campaign.synthetic import made_up as made_up_runs
from wmr_ctrl.results.table import table_of_rows
from wmr_ctrl.simulation.campaign.plan import PlannedCase

LIMITED = "torque limit 10 N m"
CASES = {
    (plant, run.case.name, run.case.law): run.case
    for plant, studies in RIGID_STUDIES.items()
    for study in studies
    for run in study.planned(("pid", "smc", "mb", "nn", "prox"), [0], plant)
}


def test_a_slope_is_as_steep_and_rises_the_same_way_on_both():
    plane, body = (CASES[plant, SLOPED, "mb"].overridden() for plant in ("ode", "mujoco"))

    assert plane.effects["slope"].angle == body.body.slope == pytest.approx(math.radians(5))
    assert plane.effects["slope"].direction == body.body.uphill + math.pi / 2


def test_every_case_law_and_seed_is_run_on_both():
    with made_up_runs():
        done = run_rigid_comparison(seeds=(4, 5))

    assert done.table.rows == 2 * len(CASES)
    assert len(done.runs) == len(CASES) / 2
    assert all(run.seed == 4 for run in done.runs.values())
    assert done.table.where(case=LIMITED, law="mb", plant="mujoco").seeds == (4, 5)


def made_up(plant, seed, **values):
    row = {"ise_total": 1.0, E1_BEFORE: 0.001, E1: 0.012, "limit_ratio": 0.9, "tipped": None}
    case = PlannedCase("paper-simulation", "mb", plant=plant, name=LIMITED)
    return {**case.labels, "seed": seed, "outcome": "completed", **row, **values}


def verdicts(*rows):
    return {claim.text: claim for claim in rigid_claims(table_of_rows(rows))}


def test_claims_are_judged_on_every_seed():
    plane = [made_up("ode", seed) for seed in (0, 1)]
    good = verdicts(
        *plane, made_up("mujoco", 0, ise_total=1.04), made_up("mujoco", 1, ise_total=0.99)
    )
    same, growth = "With 10 N m the ISE is within 5 %", "After the change e₁ is more than 10 times"
    alike = next(claim for text, claim in good.items() if text.startswith(same))
    grown = next(claim for text, claim in good.items() if text.startswith(growth))

    assert (alike.holds, alike.numbers, alike.law) == (True, "1 to 4 %", "mb")
    assert (grown.holds, grown.numbers) == (True, "12")
    assert not any("slope" in text or "nn" in claim.law for text, claim in good.items())

    one_bad = verdicts(*plane, made_up("mujoco", 0), made_up("mujoco", 1, ise_total=1.06))
    alike = next(claim for text, claim in one_bad.items() if text.startswith(same))
    assert (alike.holds, alike.numbers) == (False, "0 to 6 %")


def test_a_run_without_the_figure_is_no_evidence():
    fell = made_up("mujoco", 0, **{"ise_total": None, E1: None, E1_BEFORE: None}, tipped=4.0)
    found = verdicts(made_up("ode", 0), fell)

    assert not any(claim.holds for claim in found.values())
    assert {claim.numbers for claim in found.values()} == {"none in 1 runs"}
