"""Read users' study plans, TOML or tables, into a checked `Study`."""

import itertools
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from numbers import Real
from pathlib import Path
from typing import TypeAlias

from wmr_ctrl.control.default_law import UNSTATED, default_law
from wmr_ctrl.control.laws.given import LawGiven, law_names
from wmr_ctrl.control.laws.law import Law
from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError, show
from wmr_ctrl.core.fields.files import parse_toml, read_text
from wmr_ctrl.core.fields.named_units import Stated, with_units
from wmr_ctrl.core.fields.section import Section, build, quantities, quantity
from wmr_ctrl.core.fields.values import SEED_END, Frozen, as_list
from wmr_ctrl.results import PLANTS
from wmr_ctrl.results.figures import FIGURES, RIGID, SHARES, SUMMED
from wmr_ctrl.world.scenario import Scenario, load_scenario, override
from wmr_ctrl.world.scenario.toml_io import is_path, naming_file, stated_keys

from .intervals import StopRule
from .plan import LATIN, SOBOL, UNIFORM, SamplePlan, Study

Raw: TypeAlias = Mapping[str, object]
ENABLED = "guard.enabled"
CHUNKS = {"ode": 1024, "mujoco": 32}
"""Runs between two times that results are written: some minutes at most."""
MOST_RUNS = 10**9


def _table(doc: str) -> Mapping[str, object]:
    """A field of `PlanTable` that is a table."""
    field: Mapping[str, object] = quantity(Frozen(), "", doc, kind="mapping")
    return field


class PlanTable(Section):
    """Keys of a plan beside its scenario."""

    laws: tuple[str, ...] = quantity((UNSTATED,), "", "control laws", kind="texts")
    guard: tuple[bool, ...] = quantity((), "", "which runs have the guard", kind="flags")
    plant: str = quantity("ode", "", "plane model, or rigid body", options=PLANTS)
    seeds: Mapping[str, object] = _table("first seed and number of seeds")
    set: Mapping[str, object] = _table("fields of all runs")
    grid: Mapping[str, object] = _table("values of fields")
    sample: Mapping[str, object] = _table("ranges of fields, and how they are sampled")
    stop: Mapping[str, object] = _table("when a case has enough runs")
    figures: tuple[str, ...] = quantity((), "", "names of figures", kind="texts")
    chunk: int = quantity(1024, "1", "runs between two writes", minimum=1, below=SEED_END)

    def relate(self) -> None:
        """Raise ScenarioError if a law or flag is listed twice."""
        for name, listed in (("laws", self.laws), ("guard", self.guard)):
            if len(set(listed)) < len(listed):
                raise ScenarioError(f"{name} = {show(listed)} has a value twice; give each once.")


class Seeds(Section, key="seeds"):
    """Consecutive seeds."""

    first: int = quantity(0, "1", "first seed", minimum=0, below=SEED_END)
    count: int = quantity(20, "1", "number of seeds", minimum=1, below=SEED_END)

    def relate(self) -> None:
        """Raise ScenarioError if the last seed is too large."""
        if self.first + self.count >= SEED_END:
            raise ScenarioError(f"seeds.first + seeds.count must be below {SEED_END}.")


class SampleTable(Section, key="sample"):
    """Sampling of a box of fields; the other keys of its table are the fields' ranges."""

    method: str = quantity(LATIN, "", "kind of sample", options=(LATIN, SOBOL, UNIFORM))
    n: int = quantity(64, "1", "size of the sample", minimum=1, below=SEED_END)
    seed: int = quantity(0, "1", "seed of its draws", minimum=0, below=SEED_END)


KEYS = ("scenario", *(name for name, _ in quantities(PlanTable)))


def load_plan(path: str | Path) -> Study:
    """The plan of a TOML file; a scenario in it is relative to the file."""
    file = Path(path)
    raw = parse_toml(read_text(file, "plan"), file)
    if not raw:
        raise ArgumentError(f'{file} is empty. Give at least one key, such as laws = ["nn"].')
    with naming_file(file):
        return plan_of(raw, file.parent)


def plan_of(raw: Raw, folder: Path = Path()) -> Study:
    """The plan of a raw table, checked.

    Raises ArgumentError for a bad entry, UnknownNameError for a figure or key of the plan,
    ScenarioError for a field or value of the scenario; each names the key.
    """
    for key in raw:
        if key not in KEYS:
            raise UnknownNameError("key of a plan", key, KEYS)
    given = {key: value for key, value in raw.items() if key not in ("scenario", "seeds")}
    given |= {key: with_units(given[key]) for key in ("set", "grid", "sample") if key in given}
    if (listed := as_list(given.get("laws"))) is not None:
        given["laws"] = law_names(map(_law_given, listed), folder)
    table = build(PlanTable, given, "")
    fixed = flat(table.set)
    source = _source(raw.get("scenario", "paper-simulation"), folder)
    scenario = override(load_scenario(source) if isinstance(source, str) else source, fixed)
    sample, seeds = _sample(table.sample) if "sample" in raw else None, _seeds(raw.get("seeds", 20))
    figures = _figures(table.figures, table.plant)
    study = Study(
        scenario,
        seeds.count,
        laws=table.laws if "laws" in raw else (default_law(scenario).name,),
        guards=table.guard or (scenario.guard.enabled,),
        plant=table.plant,
        first_seed=seeds.first,
        grid={key: _values(key, values) for key, values in flat(table.grid).items()},
        sample=sample,
        stop=_stop(raw["stop"], figures) if "stop" in raw else None,
        figures=figures,
        chunk=table.chunk if "chunk" in raw else CHUNKS[table.plant],
    )
    varied = {"grid": study.grid, "sample": sample.ranges if sample else {}}
    _check_places({"set": fixed, **varied})
    _check_guard({**varied, **({"set": fixed} if "guard" in raw else {})})
    _check(study)
    keys = (*fixed, *study.grid, *varied["sample"])
    stated = stated_keys(source if isinstance(source, str) else "", keys)
    return replace(study, stated=frozenset(stated))


def _check_places(tables: Mapping[str, Iterable[str]]) -> None:
    """Raise if a field is in two tables."""
    for one, two in itertools.combinations(tables, 2):
        double = sorted({*tables[one]} & {*tables[two]})
        if double:
            raise ArgumentError(
                f"{', '.join(double)}: it is in both [{one}] and [{two}]. Give it in one, "
                "not both: [set] is for what all runs share, [grid] and [sample] for what differs."
            )


def _check_guard(tables: Mapping[str, Iterable[str]]) -> None:
    """Raise if a table sets guard.enabled, which the plan's `guard` states."""
    for name, keys in tables.items():
        if ENABLED in keys:
            raise ArgumentError(
                f"{ENABLED} is in [{name}]; in a plan `guard` at the top says which runs have "
                "it, such as guard = [false, true]."
            )


def _check(plan: Study) -> None:
    """Raise if there are too many runs, or a single value is refused."""
    sizes = [len(plan.laws), len(plan.guards), plan.seeds, *map(len, plan.grid.values())]
    if plan.sample:
        sizes.append(plan.sample.n)
    if math.prod(sizes) > MOST_RUNS:
        raise ArgumentError(
            f"the plan has {math.prod(sizes):.3g} runs; at most {MOST_RUNS:.0e} can be planned. "
            "Use fewer seeds or values, or [sample] in place of [grid]."
        )
    ends = plan.sample.ranges.items() if plan.sample else ()
    for key, values in (*plan.grid.items(), *ends):
        for value in values:
            override(plan.loaded, {key: value})


def flat(table: Raw, head: str = "") -> dict[str, object]:
    """Key paths of nested tables: ``"robot.m"`` and robot.m are one key."""
    rows: dict[str, object] = {}
    for key, value in table.items():
        path = f"{head}.{key}" if head else key
        rows |= flat(value, path) if isinstance(value, Mapping) else {path: value}
    return rows


def _law_given(item: object) -> LawGiven:
    """Check that an element of ``laws`` is a name, a file or a Law."""
    if isinstance(item, str | Path | Law):
        return item
    raise ArgumentError(f"laws: {show(item)} is not a law's name, the path of its file or a Law.")


def _source(given: object, folder: Path) -> str | Scenario:
    if isinstance(given, Scenario):
        return given
    if not isinstance(given, str):
        raise ArgumentError("scenario must be a preset's name or the path of a TOML file.")
    return str(folder / given) if is_path(given) or (folder / given).is_file() else given


def _seeds(given: object) -> Seeds:
    if isinstance(given, Mapping):
        return build(Seeds, given)
    return Seeds(count=dict(quantities(Seeds))["count"].clean(given, "seeds"))


def _values(key: str, values: object) -> tuple[object, ...]:
    if not isinstance(values, list | tuple) or not values:
        raise ArgumentError(f"grid.{key} = {values!r} must be a list with at least one value.")
    if len({json.dumps(value) for value in values}) < len(values):
        raise ArgumentError(f"grid.{key} has a value twice; give each once.")
    return tuple(values)


def _sample(table: Raw) -> SamplePlan:
    rest = {key: value for key, value in table.items() if "." in key or isinstance(value, Mapping)}
    how = build(SampleTable, {key: value for key, value in table.items() if key not in rest})
    inner = rest.pop("ranges", {})
    ranges = {}
    for key, pair in flat({**rest, **(inner if isinstance(inner, Mapping) else {})}).items():
        items = pair if isinstance(pair, list | tuple) else ()
        numbers = [v if isinstance(v, Stated) else float(v) for v in items if isinstance(v, Real)]
        if len(items) != 2 or len(numbers) != 2 or not numbers[0] < numbers[1]:
            raise ArgumentError(f"sample: {key} = {pair!r} must be a range [low, high].")
        ranges[key] = (numbers[0], numbers[1])
    if not ranges:
        raise ArgumentError("sample has no range: give a key and [low, high].")
    if how.n * len(ranges) > 10**8:
        raise ArgumentError(f"sample.n = {how.n}: at most 1e8 numbers can be drawn.")
    return SamplePlan(how.method, how.n, how.seed, ranges)


def _figures(names: Sequence[str], plant: str) -> tuple[str, ...]:
    """The named figures, or all that need no log."""
    on_tyres = plant == "mujoco"
    if not names:
        return (*SHARES, *(f.name for f in (*SUMMED, *(RIGID if on_tyres else ()))))
    known = [figure.name for figure in FIGURES if on_tyres or figure not in RIGID]
    for name in names:
        if name not in known:
            raise UnknownNameError("figure", name, known)
    return tuple(dict.fromkeys(names))


def _stop(given: object, figures: tuple[str, ...]) -> StopRule:
    rule = build(StopRule, given)
    if rule.figure not in figures:
        raise UnknownNameError("figure of the study", rule.figure, figures)
    return rule
