"""The plane model beside the rigid body: which runs are made, and what is kept of them."""

from __future__ import annotations

import math

import pytest

from tests.campaign.synthetic import in_turn, prepared, simulate
from wmr_ctrl.campaign.rigid import RIGID_CASES, run_rigid_comparison
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
    engines = dict.fromkeys(("ode", "mujoco"), (in_turn, prepared(simulate)))
    done = run_rigid_comparison(engines, seeds=(4, 5))
    laws = sum(len(case.laws) for case in RIGID_CASES)

    assert len(done.rows) == 2 * 2 * laws
    assert len(done.runs) == 2 * laws
    assert all(run.seed == 4 for run in done.runs.values())
    first = RIGID_CASES[0]
    assert [row.seed for row in done.of(first.name, first.laws[0], "mujoco")] == [4, 5]
