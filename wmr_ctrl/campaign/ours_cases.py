"""The comparison from end to end: compile each of its loops once, then run every case."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from wmr_ctrl.campaign.ours import Case
from wmr_ctrl.campaign.ours_run import SCENARIO, Comparison, compare_laws
from wmr_ctrl.campaign.progress import Progress, Silent
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.results import Run

Engine: TypeAlias = Callable[[int], Run]
"""A compiled loop as a function of the seed."""

BuildCase: TypeAlias = Callable[[str, str, bool, Mapping[str, Any]], Engine]
"""(scenario, law, guard, overrides) -> Engine; raises ScenarioError for what cannot be."""


class Engines:
    """Loops compiled beforehand; as a function it is a SimulateCase, safe for several threads."""

    def __init__(self, build: BuildCase) -> None:
        self._build = build
        self._known: dict[str, Engine | ScenarioError] = {}

    def prepare(self, plan: Sequence[Case], progress: Progress) -> None:
        """Compile the loop of every case, once for all of its seeds; refusals are kept."""
        wanted = {key_of(SCENARIO, c.law, c.guard, c.overrides): c for c in plan}
        progress.start(len(wanted), "Compiling the laws with and without the guard")
        try:
            for key, case in wanted.items():
                self._known[key] = self._built(case)
                progress.advance(1)
        finally:
            progress.done()

    def __call__(
        self, scenario: str, law: str, seed: int, guard: bool, overrides: Mapping[str, Any]
    ) -> Run:
        """The run of a prepared case; raises the ScenarioError with which it was refused."""
        engine = self._known[key_of(scenario, law, guard, overrides)]
        if isinstance(engine, ScenarioError):
            raise engine
        return engine(seed)

    def _built(self, case: Case) -> Engine | ScenarioError:
        try:
            return self._build(SCENARIO, case.law, case.guard, case.overrides)
        except ScenarioError as refusal:
            return refusal


def key_of(scenario: str, law: str, guard: bool, overrides: Mapping[str, Any]) -> str:
    """What tells one compiled loop from another."""
    return repr((scenario, law, guard, sorted(overrides.items())))


def run_ours(
    build: BuildCase,
    plan: Sequence[Case],
    jobs: int | None = None,
    progress: Progress | None = None,
) -> tuple[Comparison, ...]:
    """Compile and run ``plan``, two phases of ``progress``; rows in the plan's order."""
    shown, engines = progress or Silent(), Engines(build)
    engines.prepare(plan, shown)
    shown.start(len(plan), "Running the laws with and without the guard")
    try:
        return compare_laws(engines, plan, jobs, lambda _: shown.advance(1))
    finally:
        shown.done()
