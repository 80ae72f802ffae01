"""The comparison from end to end: compile each of its loops once, then run every case."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from wmr_ctrl.campaign.ours import Case
from wmr_ctrl.campaign.ours_run import REFUSED, SCENARIO, Comparison, comparison_of
from wmr_ctrl.campaign.progress import Progress, Silent
from wmr_ctrl.campaign.run import Loop, Simulate, followed
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.results import Run
from wmr_ctrl.sim.batch import check_jobs

BuildCase: TypeAlias = Callable[[str, str, bool, Mapping[str, Any]], Loop]
"""(scenario, law, guard, overrides) -> Loop; raises ScenarioError for what cannot be."""


def run_ours(
    simulate: Simulate,
    build: BuildCase,
    plan: Sequence[Case],
    jobs: int | None = None,
    progress: Progress | None = None,
) -> tuple[Comparison, ...]:
    """Compile and run ``plan``, two phases of ``progress``; rows in the plan's order.

    A guard's refusal becomes a row; that of an unguarded case is raised.  Results do not depend on
    ``jobs``.
    """
    check_jobs(jobs)
    shown = progress or Silent()
    loops = _built(build, plan, shown)
    running = [case for case in plan if loops[_key(case)] is not None]

    def row(place: int, run: Run) -> Comparison:
        return comparison_of(running[place], run)

    runs = [(loops[_key(case)], case.seed) for case in running]
    text = "Running the laws with and without the guard"
    found = iter(followed(simulate, runs, row, jobs, shown, text))
    refused = (Comparison(case, REFUSED) if loops[_key(case)] is None else None for case in plan)
    return tuple(row or next(found) for row in refused)


def _built(build: BuildCase, plan: Sequence[Case], progress: Progress) -> dict[str, Loop]:
    """The loop of every case by its key, once for all seeds; None where the guard refuses."""
    wanted, loops = {_key(case): case for case in plan}, {}
    progress.start(len(wanted), "Compiling the laws with and without the guard")
    try:
        for key, case in wanted.items():
            loops[key] = _loop(build, case)
            progress.advance(1)
    finally:
        progress.done()
    return loops


def _loop(build: BuildCase, case: Case) -> Loop:
    try:
        return build(SCENARIO, case.law, case.guard, case.overrides)
    except ScenarioError:
        if not case.guard:
            raise
        return None


def _key(case: Case) -> str:
    """What tells one compiled loop from another."""
    return repr((case.law, case.guard, sorted(case.overrides.items())))
