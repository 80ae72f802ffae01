"""The one engine of many runs: cases are compiled once each, then run for all their seeds.

The paper's sections, the comparison past the paper and every study of a user go through here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias, TypeVar, runtime_checkable

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.ready import Ready

Overrides: TypeAlias = Mapping[str, object]
"""Fields of a scenario by key path, such as ``clock.control``."""
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class PlannedCase:
    """What all seeds share: scenario (a preset's name, or the thing itself), law, guard, changes.

    ``guard`` None: as the scenario says.
    """

    scenario: str | Scenario
    law: str
    guard: bool | None = None
    overrides: Overrides = field(default_factory=dict, hash=False)


@dataclass(frozen=True, slots=True)
class Refusal:
    """A guard's words where it cannot keep its limits under the bounds of a case."""

    text: str


class Prepare(Protocol):
    """Compiles the loop of a case, such as `wmr_ctrl.api.compile_loop`."""

    def __call__(
        self,
        scenario: str | Scenario,
        law: str,
        overrides: Overrides | None = None,
        guard: bool | None = None,
    ) -> Ready:
        """The loop; raises ScenarioError for what cannot be."""


@runtime_checkable
class PhaseProgress(Protocol):
    """Whatever shows progress; each phase of a job is one ``start``, many ``advance``, ``done``."""

    def start(self, total: int, text: str) -> None:
        """A phase of ``total`` steps begins; ``text`` says what it does."""

    def advance(self, count: int = 1) -> None:
        """``count`` further steps of the phase are done."""

    def done(self) -> None:
        """The phase is over, finished or given up."""


class Silent:
    """Progress that nobody looks at."""

    def start(self, total: int, text: str) -> None:
        """Show nothing."""

    def advance(self, count: int = 1) -> None:
        """Show nothing."""

    def done(self) -> None:
        """Show nothing."""


class Simulate(Protocol):
    """Runs many loops at a time, such as `wmr_ctrl.sim.many.run_each`."""

    def __call__(
        self,
        runs: Sequence[tuple[Ready, int]],
        then: Callable[[int, Run], T],
        jobs: int | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> list[T]:
        """What ``then`` makes of place and Run of each (loop, seed), in their order."""


def prepared_cases(
    prepare: Prepare, cases: Iterable[PlannedCase], progress: PhaseProgress, text: str
) -> list[Ready | Refusal]:
    """The loop of each case, in their order, each different one compiled once.

    A guard that refuses gives its Refusal; what cannot be without the guard either is raised.
    """
    listed = list(cases)
    known: dict[str, Ready | Refusal] = {}
    keys = [case_key(case) for case in listed]
    different = dict(zip(keys, listed, strict=True))
    progress.start(len(different), text)
    try:
        for key, case in different.items():
            known[key] = _prepared(prepare, case)
            progress.advance(1)
    finally:
        progress.done()
    return [known[key] for key in keys]


def case_key(case: PlannedCase) -> str:
    """What tells one compiled loop from another."""
    source = case.scenario if isinstance(case.scenario, str) else hash(case.scenario)
    return repr((source, case.law, case.guard, sorted(case.overrides.items())))


def _prepared(prepare: Prepare, case: PlannedCase) -> Ready | Refusal:
    try:
        return prepare(case.scenario, case.law, case.overrides, case.guard)
    except ScenarioError as error:
        if not case.guard:
            raise
        refusal = Refusal(str(error))
    prepare(case.scenario, case.law, case.overrides, False)
    return refusal


def run_cases(
    simulate: Simulate,
    prepare: Prepare,
    runs: Sequence[tuple[PlannedCase, int]],
    then: Callable[[int, Run], T],
    jobs: int | None,
    progress: PhaseProgress,
    texts: tuple[str, str],
) -> list[T | Refusal]:
    """What ``then`` makes of place and Run of each (case, seed), in their order; or the Refusal.

    Two phases of ``progress``, compiling and running, called ``texts``.  Nothing depends on
    ``jobs``.
    """
    loops = prepared_cases(prepare, (case for case, _ in runs), progress, texts[0])
    ready: list[tuple[Ready, int]] = []
    places: list[int] = []
    for place, (loop, (_, seed)) in enumerate(zip(loops, runs, strict=True)):
        if not isinstance(loop, Refusal):
            ready.append((loop, seed))
            places.append(place)
    finished = _followed(
        simulate, ready, lambda k, run: then(places[k], run), jobs, progress, texts[1]
    )
    results = iter(finished)
    return [loop if isinstance(loop, Refusal) else next(results) for loop in loops]


def _followed(
    simulate: Simulate,
    runs: Sequence[tuple[Ready, int]],
    then: Callable[[int, Run], T],
    jobs: int | None,
    progress: PhaseProgress,
    text: str,
) -> list[T]:
    """What ``simulate`` gives, as a phase of ``progress`` that counts the runs."""
    done = 0

    def advance_to(share: float) -> None:
        nonlocal done
        count = round(share * len(runs)) - done
        done += count
        progress.advance(count)

    progress.start(len(runs), text)
    try:
        return simulate(runs, then, jobs, advance_to)
    finally:
        progress.done()
