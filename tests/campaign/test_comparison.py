"""The comparison with and without the guard: its plan, its rows, and what it finds.

By default on the cases that decide; `-m slow` runs so many that every two of law, factor and base
meet, with and without the guard. `wmr-ctrl reproduce` runs the whole plan.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations

import pytest

from tests.campaign.synthetic import Watch, made_up
from wmr_ctrl.campaign import PlannedCase
from wmr_ctrl.campaign.comparison import (
    BASES,
    FACTORS,
    HELD_OUT,
    OUR_LAWS,
    ComparisonCase,
    GuardComparison,
    comparison_plan,
    run_comparison,
    swept,
)
from wmr_ctrl.errors import ScenarioError

pytestmark = pytest.mark.usefixtures("one_set_of_instructions")

WEAK = "tau_max = 5 N m"
ONE = HELD_OUT[:1]
DECISIVE = (
    *comparison_plan(OUR_LAWS, ONE, ("10 ms",), ("adversary",)),
    *comparison_plan(("mb",), ONE, ("10 ms",), (WEAK,)),
    *comparison_plan(("prox",), ONE, ("100 ms",), ("base", "start outside")),
)
"""Every law pushed over its limit, the refusal, the long hold, the start beyond the limits."""


def meets() -> tuple[ComparisonCase, ...]:
    """Of two bases that a factor has, each law gets one in turn; and what decides."""
    plan = comparison_plan(seeds=ONE)
    bases = {(case.factor, case.base) for case in plan}
    places = [list(names) for names in (OUR_LAWS, FACTORS, BASES)]

    def chosen(case: ComparisonCase) -> bool:
        values = (case.law, case.factor, case.base)
        turn = sum(names.index(value) for names, value in zip(places, values, strict=True)) % 2 == 0
        return turn or case in DECISIVE or sum(case.factor == factor for factor, _ in bases) == 1

    return tuple(case for case in plan if chosen(case))


TINY = comparison_plan(("smc", "prox"), bases=("10 ms",), factors=("base", WEAK))


def shortened(plan: Sequence[ComparisonCase]) -> list[ComparisonCase]:
    """The same cases, for 10 s."""

    def short(case: ComparisonCase) -> ComparisonCase:
        changes = [change for change in case.overrides.get("changes", []) if change["t"] < 10.0]
        shorter = {**case.overrides, "clock.duration": 10.0, "changes": changes}
        return replace(case, overrides=shorter)

    return list(map(short, plan))


# -- the plan -----------------------------------------------------------------------------


def test_plan_has_every_case_once() -> None:
    plan = comparison_plan()
    keys = {(c.base, c.factor, c.law, c.guard, c.seed) for c in plan}

    assert len(keys) == len(plan)
    assert {c.law for c in plan} == set(OUR_LAWS)
    assert {c.factor for c in plan} == set(FACTORS)
    assert {c.seed for c in plan} == set(HELD_OUT)
    assert {c.base for c in plan} == set(BASES)


def test_what_is_run_slowly_brings_every_two_values_together() -> None:
    def pairs(plan: Iterable[ComparisonCase]) -> set[object]:
        rows = ((c.law, c.factor, c.base, c.guard) for c in plan)
        return {pair for row in rows for pair in combinations(enumerate(row), 2)}

    assert pairs(meets()) == pairs(comparison_plan(seeds=ONE))


def test_sweeps_have_the_numbers_of_their_factors() -> None:
    assert swept("clock.control") == [(0.001, "T = 1 ms"), (0.02, "T = 20 ms"), (0.05, "T = 50 ms")]
    assert len(swept("actuator.tau_max")) == 4


# -- real runs ----------------------------------------------------------------------------


@pytest.fixture(
    scope="module",
    params=["decisive", pytest.param("every two", marks=pytest.mark.slow)],
)
def comparison(request: pytest.FixtureRequest) -> GuardComparison:
    plan = DECISIVE if request.param == "decisive" else meets()
    return run_comparison(shortened(plan))


def test_guarded_runs_from_inside_keep_the_limits(comparison: GuardComparison) -> None:
    guarded = [r for r in comparison.rows if r.case.guard and r.case.factor != "start outside"]

    assert {r.outcome for r in guarded} == {"completed", "refused"}
    assert all(r.violations == 0 for r in guarded)


def test_only_the_torque_limit_that_is_too_low_is_refused(comparison: GuardComparison) -> None:
    refused = [row for row in comparison.rows if row.outcome == "refused"]

    assert {row.case.factor for row in refused} == {WEAK}
    assert all("tau_max" in row.refusal for row in refused)
    assert not any(row.refusal for row in comparison.rows if row not in refused)


def test_without_the_guard_limits_break(comparison: GuardComparison) -> None:
    """Kanayama's command ends 5 % below the limit, which is enough in some of the cases."""
    broken = {r.case.law for r in comparison.rows if not r.case.guard and r.violations}

    assert broken | {"kanayama"} == set(OUR_LAWS)


def test_position_is_told_where_a_run_lasts_that_long(comparison: GuardComparison) -> None:
    long = [row for row in comparison.rows if row.e1_after is not None]

    assert all(row.position_rms <= row.position_max for row in long)
    assert all(row.e1_after <= row.position_max for row in long)


def test_result_does_not_depend_on_the_number_of_threads(comparison: GuardComparison) -> None:
    few = [r.case for r in comparison.rows if r.case.law == "mb" and r.case.base == "10 ms"]
    alone = run_comparison(few, jobs=1)

    assert alone.rows == tuple(r for r in comparison.rows if r.case in few)


def test_share_in_clip_is_told_of_guarded_runs_alone(comparison: GuardComparison) -> None:
    without = {r.clipped is None for r in comparison.rows if not r.case.guard}
    guarded = {r.clipped is None for r in comparison.guarded()}

    assert (without, guarded) == ({True}, {False})


# -- made-up runs -------------------------------------------------------------------------


def test_each_loop_is_compiled_once_and_refusals_are_rows() -> None:
    built, watch = Counter(), Watch()

    def asked(case: PlannedCase) -> None:
        weak = case.overrides.get("actuator.tau_max")
        built[case.law, case.guard, weak] += 1
        if case.guard and weak == 5.0:
            raise ScenarioError("too weak")

    with made_up(asked=asked):
        rows = run_comparison(TINY, 2, watch).rows

    assert [row.case for row in rows] == list(TINY)
    assert set(built.values()) == {1}
    assert len(built) == 2 * 2 * 2
    assert watch.left == [0, 0]
    assert {r.refusal for r in rows if r.case.guard and r.case.factor == WEAK} == {"too weak"}


def test_unguarded_errors_are_not_swallowed() -> None:
    def refusing(_: PlannedCase) -> None:
        raise ScenarioError("no")

    with made_up(asked=refusing), pytest.raises(ScenarioError):
        run_comparison([case for case in TINY if not case.guard][:1])
