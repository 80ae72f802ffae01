"""The plan of a study: scenario, laws, guards, plant, seeds, grid, sample, rule to stop; as TOML.

Runs are counted by an index: points of grid and sample, then laws, then guards, then seeds (the
last change fastest).  A run is what its index says, whoever makes it, in whatever order.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

from wmr_ctrl.campaign.engine import PlannedCase
from wmr_ctrl.campaign.intervals import StopRule
from wmr_ctrl.campaign.study_sample import LATIN, SOBOL, UNIFORM, SamplePlan
from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fields.files import parse_toml, read_text
from wmr_ctrl.fields.limits import SEED_END
from wmr_ctrl.fields.problems import show
from wmr_ctrl.fields.section import build
from wmr_ctrl.results import PLANTS
from wmr_ctrl.results.figures import FIGURES, RIGID, SHARES, SUMMED
from wmr_ctrl.scenario import Scenario, load_scenario, override, scenario_dict
from wmr_ctrl.scenario.scenario import sections
from wmr_ctrl.scenario.toml_io import is_path

Raw: TypeAlias = Mapping[str, object]
KEYS = (
    "scenario", "laws", "guard", "plant", "seeds", "set", "grid", "sample", "stop", "figures",
    "chunk",
)  # fmt: skip
ENABLED = "guard.enabled"
CHUNKS = {"ode": 1024, "mujoco": 32}
"""Runs between two times that results are written: some minutes at most."""
MOST_RUNS = 10**9


@dataclass(frozen=True)
class StudyPlan:
    """What a study runs; made by `plan_of`, which checks it."""

    scenario: Scenario
    laws: tuple[str, ...]
    guards: tuple[bool, ...]
    plant: str
    first_seed: int
    seeds: int
    grid: Mapping[str, tuple[object, ...]]
    sample: SamplePlan | None
    stop: StopRule | None
    figures: tuple[str, ...]
    chunk: int

    @property
    def keys(self) -> tuple[str, ...]:
        """Fields that differ from run to run, in the order of the table's columns."""
        return (*self.grid, *(self.sample.ranges if self.sample else ()))

    @cached_property
    def combinations(self) -> tuple[tuple[object, ...], ...]:
        """Values of the grid's keys, the last changing fastest."""
        return tuple(itertools.product(*self.grid.values()))

    @property
    def points(self) -> int:
        """Points of grid and sample."""
        return len(self.combinations) * (len(self.sample.points) if self.sample else 1)

    @property
    def cells(self) -> int:
        """Cases that differ by more than their seed."""
        return self.points * len(self.laws) * len(self.guards)

    @property
    def runs(self) -> int:
        """Runs of the whole plan, if no rule stops it."""
        return self.cells * self.seeds

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the plan may do but had better not, one sentence each."""
        return self.sample.warnings if self.sample else ()

    def values(self, cell: int) -> tuple[object, ...]:
        """Values of `keys` in a cell."""
        point = cell // (len(self.laws) * len(self.guards))
        if self.sample is None:
            return self.combinations[point]
        row, place = divmod(point, len(self.sample.points))
        return (*self.combinations[row], *self.sample.points[place].tolist())

    def case(self, cell: int) -> PlannedCase:
        """The case of a cell."""
        law, guard = divmod(cell % (len(self.laws) * len(self.guards)), len(self.guards))
        changes = dict(zip(self.keys, self.values(cell), strict=True))
        return PlannedCase(self.scenario, self.laws[law], self.guards[guard], changes, self.plant)

    @cached_property
    def identity(self) -> str:
        """What two plans must share for one to go on where the other was interrupted."""
        points = None if self.sample is None else self.sample.points.tobytes().hex()
        text = json.dumps([self.described(), points], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    def described(self) -> dict[str, object]:
        """The plan in plain values; `chunk` is no part of what the results are."""
        sample = self.sample
        return {
            "scenario": {"name": self.scenario.name, **scenario_dict(self.scenario)},
            "laws": list(self.laws),
            "guard": list(self.guards),
            "plant": self.plant,
            "seeds": {"first": self.first_seed, "count": self.seeds},
            "grid": {key: list(values) for key, values in self.grid.items()},
            "sample": sample
            and {"method": sample.method, "n": sample.n, "seed": sample.seed,
                 "ranges": {key: list(pair) for key, pair in sample.ranges.items()}},
            "stop": self.stop and {**vars(self.stop), "share": self.stop.share},
            "figures": list(self.figures),
        }  # fmt: skip


def load_plan(path: str | Path) -> StudyPlan:
    """The plan of a TOML file; a scenario in it is relative to the file."""
    file = Path(path)
    raw = parse_toml(read_text(file, "plan"), file)
    if not raw:
        raise ArgumentError(f'{file} says nothing. Give at least one key, such as laws = ["nn"].')
    alone = {"title", "extends", "changes", "gains", "reference", *sections()} - {*KEYS}
    if alone & raw.keys():
        raise ArgumentError(
            f"{file} is a scenario, no plan of a study. A plan names one and says what is run on "
            f'it: scenario = "{file.name}", laws = ["prox"], seeds = 20 in a file of its own. One '
            f"run of it is `wmr-ctrl run {file}`."
        )
    return plan_of(raw, file.parent)


def plan_of(raw: Raw, folder: Path = Path()) -> StudyPlan:
    """The plan of a raw table, checked.

    Raises ArgumentError for a bad entry, UnknownNameError for a figure or key of the plan,
    ScenarioError for a field or value of the scenario; each names the key.
    """
    for key in raw:
        if key not in KEYS:
            raise UnknownNameError("key of a plan", key, KEYS)
    fixed = flat(_table(raw, "set"))
    scenario = override(_scenario(raw.get("scenario", "paper-simulation"), folder), fixed)
    grid = {key: _values(key, values) for key, values in flat(_table(raw, "grid")).items()}
    sample = _sample(_table(raw, "sample")) if "sample" in raw else None
    first, count = _seeds(raw.get("seeds", 20))
    plant = _plant(raw.get("plant", "ode"))
    figures = _figures(raw.get("figures"), plant)
    plan = StudyPlan(
        scenario, _texts(raw.get("laws", ["nn"])),
        _guards(raw.get("guard", [scenario.guard.enabled])), plant, first, count, grid, sample,
        _stop(raw.get("stop"), figures), figures,
        _whole(raw.get("chunk", CHUNKS[plant]), "chunk", 1),
    )  # fmt: skip
    varied = {"grid": grid, "sample": sample.ranges if sample else {}}
    _check_places({"set": fixed, **varied})
    _check_guard({**varied, **({"set": fixed} if "guard" in raw else {})})
    _check(plan)
    return plan


def _check_places(tables: Mapping[str, Iterable[str]]) -> None:
    """Raise where a field stands in two tables."""
    for one, two in itertools.combinations(tables, 2):
        double = sorted({*tables[one]} & {*tables[two]})
        if double:
            raise ArgumentError(
                f"{', '.join(double)}: it stands in [{one}] and in [{two}]. Give it in one, "
                "not both: [set] is for what all runs share, [grid] and [sample] for what differs."
            )


def _check_guard(tables: Mapping[str, Iterable[str]]) -> None:
    """Raise where a table would say again, or otherwise, what the plan's `guard` says."""
    for name, keys in tables.items():
        if ENABLED in keys:
            raise ArgumentError(
                f"{ENABLED} stands in [{name}]; in a plan `guard` at the top says which runs have "
                "it, such as guard = [false, true]."
            )


def _check(plan: StudyPlan) -> None:
    """Raise where there are too many runs, or a value by itself is refused."""
    sizes = [len(plan.laws), len(plan.guards), plan.seeds, *map(len, plan.grid.values())]
    if plan.sample:
        sizes.append(plan.sample.n)
    if math.prod(sizes) > MOST_RUNS:
        raise ArgumentError(
            f"the plan has {math.prod(sizes):.3g} runs; at most {MOST_RUNS:.0e} can be planned. "
            "Take fewer seeds or values, or a sample in place of the grid."
        )
    ends = plan.sample.ranges.items() if plan.sample else ()
    for key, values in (*plan.grid.items(), *ends):
        for value in values:
            override(plan.scenario, {key: value})


def flat(table: Raw, head: str = "") -> dict[str, object]:
    """Key paths of nested tables: ``"robot.m"`` and robot.m are the same key."""
    rows: dict[str, object] = {}
    for key, value in table.items():
        path = f"{head}.{key}" if head else key
        rows |= flat(value, path) if isinstance(value, Mapping) else {path: value}
    return rows


def _scenario(given: object, folder: Path) -> Scenario:
    if isinstance(given, Scenario):
        return given
    if not isinstance(given, str):
        raise ArgumentError("scenario must be a preset's name or the path of a TOML file.")
    return load_scenario(folder / given if is_path(given) or (folder / given).is_file() else given)


def _table(raw: Raw, key: str) -> Raw:
    table = raw.get(key, {})
    if not isinstance(table, Mapping):
        raise ArgumentError(f"{key} must be a table, written as [{key}].")
    return table


def _texts(given: object) -> tuple[str, ...]:
    names = [given] if isinstance(given, str) else given
    if not isinstance(names, Sequence) or not names or len(set(names)) < len(names):
        raise ArgumentError("laws must be a list of different names of laws, such as ['nn'].")
    return tuple(map(str, names))


def _guards(given: object) -> tuple[bool, ...]:
    flags = [given] if isinstance(given, bool) else given
    good = isinstance(flags, Sequence) and flags and all(isinstance(f, bool) for f in flags)
    if not good or not isinstance(flags, Sequence) or len(set(flags)) < len(flags):
        raise ArgumentError("guard must be a list of different flags, such as [false, true].")
    return tuple(flags)


def _seeds(given: object) -> tuple[int, int]:
    if isinstance(given, Mapping):
        if set(given) - {"first", "count"}:
            raise UnknownNameError("key of seeds", min(map(str, given)), ("first", "count"))
        first = _whole(given.get("first", 0), "seeds.first", 0)
        count = _whole(given.get("count", 20), "seeds.count", 1)
        return first, _whole(first + count, "seeds.first + seeds.count", 1) - first
    return 0, _whole(given, "seeds", 1)


def _whole(value: object, key: str, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value < SEED_END:
        raise ArgumentError(
            f"{key} = {show(value)} must be a whole number from {least} up, below {SEED_END}."
        )
    return value


def _values(key: str, values: object) -> tuple[object, ...]:
    if not isinstance(values, list | tuple) or not values:
        raise ArgumentError(f"grid.{key} = {values!r} must be a list with at least one value.")
    if len({json.dumps(value) for value in values}) < len(values):
        raise ArgumentError(f"grid.{key} has a value twice; give each once.")
    return tuple(values)


def _sample(table: Raw) -> SamplePlan:
    rest = {key: value for key, value in table.items() if key not in ("method", "n", "seed")}
    inner = rest.pop("ranges", {})
    ranges = {}
    for key, pair in flat({**rest, **(inner if isinstance(inner, Mapping) else {})}).items():
        items = pair if isinstance(pair, list | tuple) else ()
        numbers = [float(v) for v in items if isinstance(v, int | float)]
        if len(items) != 2 or len(numbers) != 2 or not numbers[0] < numbers[1]:
            raise ArgumentError(f"sample: {key} = {pair!r} must be a range [low, high].")
        ranges[key] = (numbers[0], numbers[1])
    method = table.get("method", LATIN)
    if method not in (LATIN, SOBOL, UNIFORM):
        raise UnknownNameError("method of a sample", str(method), (LATIN, SOBOL, UNIFORM))
    if not ranges:
        raise ArgumentError("sample has no range: give a key and [low, high].")
    n, seed = (
        _whole(table.get("n", 64), "sample.n", 1),
        _whole(table.get("seed", 0), "sample.seed", 0),
    )
    if n * len(ranges) > 10**8:
        raise ArgumentError(f"sample.n = {n}: at most 1e8 numbers can be drawn.")
    return SamplePlan(str(method), n, seed, ranges)


def _plant(given: object) -> str:
    if given not in PLANTS:
        raise UnknownNameError("plant", str(given), PLANTS)
    return str(given)


def _figures(given: object, plant: str) -> tuple[str, ...]:
    on_tyres = plant == "mujoco"
    if given is None:
        return (*SHARES, *(f.name for f in (*SUMMED, *(RIGID if on_tyres else ()))))
    known = [figure.name for figure in FIGURES if on_tyres or figure not in RIGID]
    names = [given] if isinstance(given, str) else given
    if not isinstance(names, list | tuple) or not names:
        raise ArgumentError("figures must be a list of names of figures.")
    for name in names:
        if name not in known:
            raise UnknownNameError("figure", str(name), known)
    return tuple(dict.fromkeys(map(str, names)))


def _stop(given: object, figures: tuple[str, ...]) -> StopRule | None:
    if given is None:
        return None
    rule = build(StopRule, given)
    if rule.figure not in figures:
        raise UnknownNameError("figure of the study", rule.figure, figures)
    return rule
