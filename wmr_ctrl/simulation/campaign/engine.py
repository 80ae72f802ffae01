"""The engine of many runs: each case is compiled once, then run for all its seeds."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TypeVar

from wmr_ctrl.core.errors import ArgumentError, ScenarioError, show
from wmr_ctrl.results import FIGURES, REFUSED, Run, RunTable, table_of_rows, values_of
from wmr_ctrl.simulation.batch import Progress, check_jobs
from wmr_ctrl.simulation.many import PREPARING, part, run_each
from wmr_ctrl.simulation.runnable import RunnableLoop

from .paper_runs import REPORTED
from .plan import PlannedCase, PlannedRun

T = TypeVar("T")


@dataclass(frozen=True)
class Refusal:
    """Message of a guard that cannot keep its limits under the bounds of a case."""

    text: str


def build_loop(case: PlannedCase, device: str = "cpu") -> RunnableLoop:
    """The compiled loop of a case; for the rigid body without its plant.  Raises as `settle`."""
    from wmr_ctrl.simulation.engines import runnable

    return runnable(case.overridden(), case.law, case.plant, device)


def built_loops(
    cases: Iterable[PlannedCase], progress: Progress | None = None, device: str = "cpu"
) -> list[RunnableLoop | Refusal]:
    """The loop of each case for a device, in order; equal ones are compiled once.

    If a guard refuses, its Refusal; a case that is invalid without the guard, too, raises the error
    with the properties that distinguish it.
    """
    known: dict[str, RunnableLoop | Refusal] = {}

    def built(case: PlannedCase) -> RunnableLoop | Refusal:
        key = case_key(case)
        if key not in known:
            try:
                known[key] = build_loop(case, device)
            except ScenarioError as error:
                if not case.guard:
                    raise ScenarioError(f"{error}{_apart(case, apart.values())}") from error
                built(replace(case, guard=False))
                known[key] = Refusal(str(error))
        return known[key]

    listed = list(cases)
    apart = {id(case): case for case in listed}
    keys = {place: case_key(case) for place, case in apart.items()}
    different = {keys[place]: case for place, case in apart.items()}
    for count, case in enumerate(different.values(), start=1):
        built(case)
        if progress:
            progress(count / len(different))
    return [known[keys[id(case)]] for case in listed]


def _apart(case: PlannedCase, others: Iterable[PlannedCase]) -> str:
    """Sentence on law and changes that distinguish a case from others; empty if none do."""
    apart = [
        f"{key} = {show(value)}"
        for key, value in {"law": case.law, **case.overrides}.items()
        if any({"law": other.law, **other.overrides}.get(key) != value for other in others)
    ]
    return f" Refused is the case {', '.join(apart)}." if apart else ""


def accepted(
    loops: Sequence[RunnableLoop | Refusal], seeds: Sequence[int]
) -> tuple[list[int], list[tuple[RunnableLoop, int]]]:
    """Indices of the runs that are not refused, with their loops and seeds."""
    pairs = enumerate(zip(loops, seeds, strict=True))
    ready = {k: (loop, seed) for k, (loop, seed) in pairs if not isinstance(loop, Refusal)}
    return [*ready], [*ready.values()]


def case_key(case: PlannedCase) -> str:
    """Key of a case's compiled loop."""
    source = case.scenario if isinstance(case.scenario, str) else hash(case.scenario)
    return repr((source, case.law, case.guard, case.plant, sorted(case.overrides.items())))


def run_cases(
    runs: Sequence[tuple[PlannedCase, int]],
    then: Callable[[int, Run], T],
    jobs: int | None,
    progress: Progress | None,
) -> list[T | Refusal]:
    """``then(place, run)`` of each (case, seed), in their order; or the Refusal.

    All are on the same plant.  Nothing depends on ``jobs``.
    """
    loops = built_loops((case for case, _ in runs), part(progress, 0.0, PREPARING))
    places, ready = accepted(loops, [seed for _, seed in runs])
    run = run_each
    if runs and runs[0][0].plant == "mujoco":
        from wmr_ctrl.simulation.physics.run import run_rigid_each

        run = run_rigid_each

    running = part(progress, PREPARING)
    results = iter(run(ready, lambda k, item: then(places[k], item), jobs, running))
    return [loop if isinstance(loop, Refusal) else next(results) for loop in loops]


@dataclass(frozen=True)
class Campaign:
    """A finished plan: ``table`` has a row per run, ``runs`` the full first run of each case.

    ``runs`` maps (scenario, law) to the Run of the lowest seed.  Without rows: not run.
    """

    table: RunTable = field(default_factory=RunTable)
    runs: Mapping[tuple[str, str], Run] = field(default_factory=dict)


def run_campaign(
    plan: Sequence[PlannedRun],
    jobs: int | None = None,
    progress: Progress | None = None,
    figures: Sequence[str] = REPORTED,
    whole: bool = True,
) -> Campaign:
    """Compile, then run all of ``plan`` on ``jobs`` threads (default: one per core).

    Rows have ``figures`` and those of other packages; ``whole``: keep full first runs. A guard's
    refusal becomes a row; that of an unguarded case is raised. The result is the same for any
    ``jobs``. An exception in a run, or an interrupt, ends the campaign immediately: runs that have
    not begun are dropped. Raises ArgumentError for jobs < 1 or an empty plan.
    """
    check_jobs(jobs)
    if not plan:
        raise ArgumentError("the plan is empty: name at least one law and one seed.")
    taken = FIGURES.with_others(figures)
    first: dict[tuple[str, str], int] = {}
    for case, seed in plan if whole else ():
        key = case.name, case.law
        first[key] = min(seed, first.get(key, seed))
    runs: dict[tuple[str, str], Run] = {}

    def row(place: int, run: Run) -> dict[str, object]:
        case, seed = plan[place]
        if first.get((case.name, case.law)) == seed:
            runs[case.name, case.law] = run
        return {"outcome": run.outcome.value, "refusal": "", **values_of(run, taken)}

    def refused(item: Refusal) -> dict[str, object]:
        none = dict.fromkeys(figure.name for figure in taken)
        return {"outcome": REFUSED, "refusal": item.text, **none}

    results = run_cases(plan, row, jobs, progress)
    rows = [
        {**case.labels, "seed": seed, **(refused(item) if isinstance(item, Refusal) else item)}
        for (case, seed), item in zip(plan, results, strict=True)
    ]
    ordered = {key: runs[key] for key in first if key in runs}  # threads end in any order
    return Campaign(table_of_rows(rows), MappingProxyType(ordered))
