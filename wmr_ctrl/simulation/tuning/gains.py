"""Tuning: gains of a law found by CMA-ES over runs, also for masses other than the believed one.

Objective, to be minimised: the root of the mean over all training runs of

    position_rms^2 + (weight torque_change_rms)^2

with the position's RMS over the last quarter and the torques' change over the last half of a run,
or over the drive for a path that stops (`results.measures`).  With merit = "corridor" the certified
corridor replaces position_rms (`Corridor.merit`), and gains with a corridor rank before all without
one.  The runs: every training seed, once with the scenario as it is and once for each of `MASSES`,
the true mass and inertia over the believed ones, without the scenario's changes.  A base that takes
velocities is judged by its position alone, with its own mass.  Gains with fewer runs that end early
rank first, whatever the objective of the other runs.  Gains are searched as logarithms, from the
scenario's own; the guard is off, so that it hides nothing.  The result is judged by test seeds, and
by references that were not trained on.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws.given import LawGiven, law_name
from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.files import one_command
from wmr_ctrl.core.fields.section import Section, numbers_in
from wmr_ctrl.results import FIGURES, RunTable, atomic_text, check_writable
from wmr_ctrl.simulation.engines import table_of
from wmr_ctrl.simulation.many import checked_seeds
from wmr_ctrl.theory.corridor import certified_corridor, find_corridor
from wmr_ctrl.theory.door import proofs
from wmr_ctrl.world.model.kinematics import KinematicGains
from wmr_ctrl.world.scenario import Scenario, override
from wmr_ctrl.world.scenario.toml_io import to_toml

from . import search

Progress = Callable[[float], None]
MASSES = (0.6, 1.6)
"""True over believed mass and inertia, beside the scenario's own robot."""
REFERENCES = ("lemniscate", "line")
"""References on which the result is tried besides its own."""
SEARCH = 0.9
"""Share of the time that the search takes."""
_ERRORS = ("tracking_drive_rms", "torque_change_rms")
"""Figures that are judged, less is better; of a base that takes velocities the first."""
FLOOR = 1e-6
"""A smaller error [m] or change of torque [N m] is as good as none."""


@dataclass(frozen=True)
class Tuning:
    """The scenario with the gains found, and the figures before and after.

    ``corridor``: certified before and after [m], None if there is none or it was not requested.
    """

    plan: search.TuningPlan
    scenario: Scenario
    gains: Mapping[str, tuple[float, ...]]
    objective: tuple[search.Cost, search.Cost]
    before: RunTable
    after: RunTable
    out: Path
    corridor: tuple[float | None, float | None] = (None, None)

    def to_json(self) -> dict[str, object]:
        """Plain data."""
        plan, (first, last) = self.plan, self.objective
        return {
            "scenario": plan.scenario.name, "law": plan.law, "out": str(self.out),
            "seeds": list(plan.seeds), "test_seeds": list(plan.test_seeds),
            "trials": plan.trials, "weight": plan.weight, "hold": list(plan.hold),
            "merit": plan.merit,
            "masses": [1.0, *_masses(plan.scenario)],
            "objective": {"before": first.metres, "after": last.metres},
            "ended_early": {"before": first.lost, "after": last.lost},
            "no_corridor": {"before": first.refused, "after": last.refused},
            "corridor": dict(zip(("before", "after"), self.corridor, strict=True)),
            "gains": {key: list(value) for key, value in self.gains.items()},
            "before": self.before.records(),
            "after": self.after.records(),
        }  # fmt: skip


@checks_arguments
@one_command()
def tune(
    scenario: str | Path | Scenario,
    law: LawGiven,
    out: str | Path,
    *,
    seeds: Iterable[int] = range(1, 4),
    test_seeds: Iterable[int] = range(7101, 7106),
    trials: int = 200,
    weight: float = 1e-3,
    hold: Iterable[str] = (),
    merit: str = search.TRACKING,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Tuning:
    """Find gains of ``law`` on ``scenario``, and write that scenario with them to ``out`` (.toml).

    ``weight`` [m/(N m)] weights torque change; ``hold`` lists keys of gains to keep; ``merit`` is
    "tracking", the distance in runs, or "corridor", the certified one (which takes the extra
    proofs, and a scenario and law that `find_corridor` covers); ``trials`` sets of gains are tried,
    rounded up to whole generations. Raises MissingExtraError without the extra tune, ArgumentError,
    ScenarioError, UnknownNameError, ResultFileError.
    """
    law = law_name(law)
    chosen = scenario_of(scenario)
    plan = search.TuningPlan(
        scenario=chosen,
        law=law,
        seeds=tuple(checked_seeds(seeds)),
        test_seeds=tuple(checked_seeds(test_seeds)),
        trials=trials,
        weight=weight,
        hold=tuple(hold),
        merit=merit,
    )
    if merit == search.CORRIDOR:
        _check_corridor(chosen, law)
    target, start = check_writable(out), _start(plan)
    tell, optimiser = progress or (lambda share: None), search.Search(start)
    while optimiser.tried < plan.trials:
        candidates = optimiser.ask()
        costs = _costs(plan, [optimiser.gains(item) for item in candidates], jobs)
        optimiser.tell(candidates, costs)
        tell(SEARCH * min(1.0, optimiser.tried / plan.trials))
    best = optimiser.best()
    first, last = _costs(plan, [start, best], jobs)
    if last > first:
        best, last = start, first
    better = with_gains(chosen, best)
    before, after = (judged(item, law, plan.test_seeds, jobs) for item in (chosen, better))
    tubes: tuple[float | None, float | None] = (None, None)
    if merit == search.CORRIDOR:
        tubes = certified_corridor(chosen, law).position, certified_corridor(better, law).position
    tuning = Tuning(plan, better, best, (first, last), before, after, target, tubes)
    with atomic_text(target) as file:
        file.write(_document(tuning))
    tell(1.0)
    return tuning


def _unguarded(scenario: Scenario) -> Scenario:
    return replace(scenario, guard=replace(scenario.guard, enabled=False))


def with_gains(scenario: Scenario, gains: Mapping[str, Sequence[float]]) -> Scenario:
    """The scenario with these gains; a gain of one element is a number."""
    values = {key: list(item) if len(item) > 1 else item[0] for key, item in gains.items()}
    return override(scenario, values)


def _start(plan: search.TuningPlan) -> dict[str, tuple[float, ...]]:
    law, given = LAWS[plan.law], plan.scenario.gains
    values = {}
    for key in plan.searched:
        section, name = key.split(".")[1:]
        cls: type[Section] = KinematicGains if section == "kinematics" else law.gains
        named = given.get(section, {}).get(name)
        value = numbers_in(cls(), name) if named is None else np.atleast_1d(named).tolist()
        if min(value) <= 0:
            raise ScenarioError(
                f"{key} = {named}: gains are searched as logarithms, and one of these is not above "
                "zero. Give a positive number to start from."
            )
        values[key] = tuple(float(number) for number in value)
    return values


def _masses(scenario: Scenario) -> tuple[float, ...]:
    """Ratios of true to believed mass in training and test, besides 1."""
    return () if scenario.takes_velocity else MASSES


def _robots(scenario: Scenario) -> Iterator[tuple[float, Scenario]]:
    """The unguarded scenario, then copies with other true masses than the believed one."""
    free = _unguarded(scenario)
    yield 1.0, free
    believed = scenario.believed
    model = replace(scenario.model, m=believed.m, I=believed.I, mu=believed.mu)
    for ratio in _masses(scenario):
        robot = replace(scenario.robot, m=ratio * believed.m, I=ratio * believed.I)
        yield ratio, replace(free, robot=robot, model=model, changes=())


def _costs(
    plan: search.TuningPlan, sets: Sequence[Mapping[str, Sequence[float]]], jobs: int | None
) -> list[search.Cost]:
    cases = [case for gains in sets for _, case in _robots(with_gains(plan.scenario, gains))]
    table = _table(cases, plan.law, plan.seeds, jobs)
    reached, change, stop = (
        table[name].reshape(len(sets), -1)
        for name in ("tracking_drive_rms", "torque_change_rms", "stop")
    )
    completed = (stop == 0) & np.isfinite(reached)
    weight = 0.0 if plan.scenario.takes_velocity else plan.weight
    squares = (weight * np.nan_to_num(change)) ** 2
    costs = []
    for k, gains in enumerate(sets):
        refused, distance, whole = False, reached[k], completed[k]
        if plan.merit == search.CORRIDOR:
            refused, merit = certified_corridor(with_gains(plan.scenario, gains), plan.law).merit
            distance = np.full(len(whole), merit)
        runs = (distance**2 + squares[k])[whole]
        metres = math.sqrt(runs.mean()) if len(runs) else math.inf
        costs.append(search.Cost(refused, int((~whole).sum()), metres))
    return costs


def _check_corridor(scenario: Scenario, law: str) -> None:
    """Raise ArgumentError without a corridor to minimise, MissingExtraError without its extra."""
    proofs()
    tube = find_corridor(scenario, law)
    if tube.linear is None:
        raise ArgumentError(
            f"merit = corridor: {scenario.name} with {law} has {tube.sentence}. Tune a scenario "
            "that `wmr-ctrl check` certifies a corridor for, or use merit = tracking."
        )


def _table(
    cases: Sequence[Scenario],
    law: str,
    seeds: Sequence[int],
    jobs: int | None,
    figures: Sequence[str] = (),
) -> RunTable:
    """All seeds of each case, one row per run."""
    listed = [case for case in cases for _ in seeds]
    return table_of("ode", listed, law, [*seeds] * len(cases), figures=figures, jobs=jobs)


def judged(
    scenario: str | Path | Scenario, law: str, seeds: Iterable[int], jobs: int | None = None
) -> RunTable:
    """Test of a law on a scenario as in `tune`: one row per reference and robot.

    ``reference``; ``mass``, true over believed; over the seeds the medians of tracking_drive_rms,
    torque_change_rms and other packages' figures, the greatest max_abs_v1 and max_abs_v2, and
    ``lost``, the number of runs that ended early.
    """
    chosen, listed = scenario_of(scenario), tuple(seeds)
    own, cases = chosen.reference_kind.name, []
    for kind in dict.fromkeys((own, *REFERENCES)):
        on = chosen if kind == own else override(chosen, {"reference.kind": kind})
        cases += [(kind, ratio, case) for ratio, case in _robots(on)]
    names = [figure.name for figure in FIGURES.plugins]
    table = _table([case for _, _, case in cases], law, listed, jobs, names)

    by_case = {name: values.reshape(len(cases), -1) for name, values in table.items()}
    middle = {name: np.median(by_case[name], axis=1) for name in (*_ERRORS, *names)}
    return RunTable(
        {
            "reference": np.array([kind for kind, _, _ in cases]),
            "mass": np.array([ratio for _, ratio, _ in cases]),
            **{name: middle.pop(name) for name in _ERRORS},
            **{name: by_case[name].max(axis=1) for name in ("max_abs_v1", "max_abs_v2")},
            "lost": (by_case["stop"] > 0).sum(axis=1),
            **middle,
        }
    )


def _document(tuning: Tuning) -> str:
    """The scenario's text, headed by the origin of its gains."""
    plan, (first, last) = tuning.plan, tuning.objective
    masses = ", ".join(f"{ratio:g}" for ratio in _masses(plan.scenario))
    effort = f" + ({plan.weight:g} torque_change_rms)^2" if masses else ""
    head = [
        f"gains of {plan.law} found by wmr-ctrl tune {plan.scenario.name}, without guard:",
        *([f"held: {', '.join(plan.hold)};"] if plan.hold else []),
        f"trials {plan.trials}, training seeds {list(plan.seeds)}"
        f"{f', true over believed mass 1, {masses}' if masses else ''};",
        f"root of the mean of {search.MEASURED[plan.merit]}^2{effort}: {first.sentence} before, "
        f"{last.sentence} after",
    ]  # fmt: skip
    text = to_toml(tuning.scenario, only=tuning.scenario.assumed)
    return "".join(f"# {line}\n" for line in head) + f"\n{text}"
