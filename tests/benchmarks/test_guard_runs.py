"""Comparison with and without the guard: its plan, its rows and its findings.

The tests run the decisive cases; `wmr-ctrl reproduce` runs the whole plan.
"""

from dataclasses import replace

import pytest

from benchmarks.guard_runs import (
    AWAY,
    E1,
    FARTHEST,
    HELD_OUT,
    OUR_LAWS,
    comparison_plan,
    run_comparison,
)
from tests.simulation.campaign.synthetic import made_up
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.simulation.campaign.plan import PlannedRun
from wmr_ctrl.world.scenario import load_scenario, override

WEAK = "tau_max = 5 N m"
ONE = HELD_OUT[:1]
DECISIVE = (
    *comparison_plan(OUR_LAWS, ONE, ("10 ms",), ("adversary",)),
    *comparison_plan(("mb",), ONE, ("10 ms",), (WEAK,)),
    *comparison_plan(("prox",), ONE, ("100 ms",), ("base", "start outside")),
)
"""Every law pushed over its limit, the refusal, the long hold, the start beyond the limits."""


def test_the_adversary_is_half_as_heavy_as_believed_and_pushes_by_the_whole_bound():
    """The least mass of the guard is the robot's own."""
    for item in comparison_plan(("mb",), ONE, ("10 ms",), ("adversary",)):
        case = load_scenario(item.case.scenario, dict(item.case.overrides))
        robot, believed = case.robot, case.believed
        noise = {"disturbance.push": [0.0, 0.0], "disturbance.std": 1.0}
        guard = settle(override(case, {"guard.enabled": True, **noise}), "mb").guard

        assert (2 * robot.m, 2 * robot.I) == (believed.m, believed.I)
        assert guard.M_min == (robot.m, robot.I)
        assert case.disturbance.push == guard.dbar
        assert (robot.mu, case.disturbance.std, case.changes) == (0.0, 0.0, ())


TINY = comparison_plan(("smc", "prox"), bases=("10 ms",), factors=("base", WEAK))


def shortened(plan):
    """Shorten the planned runs to 10 s, without later changes."""

    def short(case):
        changes = [change for change in case.overrides.get("changes", []) if change["t"] < 10.0]
        shorter = {**case.overrides, "clock.duration": 10.0, "changes": changes}
        return replace(case, overrides=shorter)

    return [PlannedRun(short(case), seed) for case, seed in plan]


# -- real runs ----------------------------------------------------------------------------


@pytest.mark.slow
def test_guarded_runs_from_inside_keep_the_limits_and_only_a_weak_torque_limit_is_refused():
    comparison = run_comparison(shortened(DECISIVE))
    guarded = comparison.where(guard=True)
    inside = guarded.at(guarded["case"] != "start outside")
    refused = comparison.where(outcome="refused")

    assert set(inside.different("outcome")) == {"completed", "refused"}
    assert not (inside["violations"] > 0).any()
    assert refused.different("case") == (WEAK,)
    assert all("tau_max" in text for text in refused["refusal"])
    assert ((comparison["refusal"] != "") == (comparison["outcome"] == "refused")).all()


def test_position_is_told_where_a_run_lasts_that_long():
    plan = comparison_plan(("mb",), ONE, ("10 ms",), ("base",))[:1]
    (row,) = run_comparison(plan).records()

    assert 0 < row[E1] <= row[FARTHEST]
    assert 0 < row[AWAY] <= row[FARTHEST]


# -- made-up runs -------------------------------------------------------------------------


@pytest.mark.parametrize("guard", [False, True])
def test_an_error_that_does_not_depend_on_the_guard_ends_the_comparison(guard):
    def refusing(_):
        raise ScenarioError("no")

    with (
        made_up(asked=refusing),
        pytest.raises(ScenarioError, match=r"no Refused is the case law = "),
    ):
        run_comparison([run for run in TINY if run.case.guard is guard])
