"""The one engine of many runs: cases are compiled once each, then run for all their seeds.

The paper's sections, the comparison past the paper and every study of a user go through here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol, TypeAlias, TypeVar, runtime_checkable

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import Scenario, load_scenario, override
from wmr_ctrl.sim.many import run_each
from wmr_ctrl.sim.runnable import RunnableLoop

Overrides: TypeAlias = Mapping[str, object]
"""Fields of a scenario by key path, such as ``clock.control``."""
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class PlannedCase:
    """What all seeds share: scenario (a preset's name, or the thing itself), law, guard, changes.

    ``guard`` None: as the scenario says; ``plant`` "mujoco" is the rigid body.  ``name``: what
    tables call it; ``base``: the group of cases that it is compared in.
    """

    scenario: str | Scenario
    law: str
    guard: bool | None = None
    overrides: Overrides = field(default_factory=dict, hash=False)
    plant: str = "ode"
    name: str = ""
    base: str = ""


class PlannedRun(NamedTuple):
    """A run to be made."""

    case: PlannedCase
    seed: int


@dataclass(frozen=True, slots=True)
class Refusal:
    """A guard's words where it cannot keep its limits under the bounds of a case."""

    text: str


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


def build_loop(case: PlannedCase) -> RunnableLoop:
    """The compiled loop of a case, without its plant for the rigid body.  Raises as `settle`."""
    from wmr_ctrl.engines import (
        runnable_batch,
        runnable_plantless,
    )  # a worker that builds none is light

    build = runnable_batch if case.plant == "ode" else runnable_plantless
    return build(scenario_of(case), case.law)


def scenario_of(case: PlannedCase) -> Scenario:
    """The scenario with what the case changes.  Raises ScenarioError."""
    switch = {} if case.guard is None else {"guard.enabled": case.guard}
    base = load_scenario(case.scenario) if isinstance(case.scenario, str) else case.scenario
    changed = {**case.overrides, **switch}
    return override(base, changed) if changed else base


def built_loops(
    cases: Iterable[PlannedCase], progress: PhaseProgress, text: str
) -> list[RunnableLoop | Refusal]:
    """The loop of each case, in their order, each different one compiled once.

    A guard that refuses gives its Refusal; what cannot be without the guard either is raised.
    """
    known: dict[str, RunnableLoop | Refusal] = {}

    def built(case: PlannedCase) -> RunnableLoop | Refusal:
        key = case_key(case)
        if key not in known:
            try:
                known[key] = build_loop(case)
            except ScenarioError as error:
                if not case.guard:
                    raise
                built(replace(case, guard=False))
                known[key] = Refusal(str(error))
        return known[key]

    keyed = [(case_key(case), case) for case in cases]
    different = dict(keyed)
    progress.start(len(different), text)
    try:
        for case in different.values():
            built(case)
            progress.advance(1)
    finally:
        progress.done()
    return [known[key] for key, _ in keyed]


def case_key(case: PlannedCase) -> str:
    """What tells one compiled loop from another."""
    source = case.scenario if isinstance(case.scenario, str) else hash(case.scenario)
    return repr((source, case.law, case.guard, case.plant, sorted(case.overrides.items())))


def run_cases(
    runs: Sequence[tuple[PlannedCase, int]],
    then: Callable[[int, Run], T],
    jobs: int | None,
    progress: PhaseProgress,
    texts: tuple[str, str],
) -> list[T | Refusal]:
    """What ``then`` makes of place and Run of each (case, seed), in their order; or the Refusal.

    All are on the same plant.  Two phases of ``progress``, compiling and running, called ``texts``.
    Nothing depends on ``jobs``.
    """
    loops = built_loops((case for case, _ in runs), progress, texts[0])
    ready: list[tuple[RunnableLoop, int]] = []
    places: list[int] = []
    for place, (loop, (_, seed)) in enumerate(zip(loops, runs, strict=True)):
        if not isinstance(loop, Refusal):
            ready.append((loop, seed))
            places.append(place)
    run, done = run_each, 0
    if runs and runs[0][0].plant == "mujoco":
        from wmr_ctrl.physics.run import run_rigid_each

        run = run_rigid_each

    def advance_to(share: float) -> None:
        nonlocal done
        count = round(share * len(ready)) - done
        done += count
        progress.advance(count)

    progress.start(len(ready), texts[1])
    try:
        results = iter(run(ready, lambda k, item: then(places[k], item), jobs, advance_to))
    finally:
        progress.done()
    return [loop if isinstance(loop, Refusal) else next(results) for loop in loops]
