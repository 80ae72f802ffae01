"""Plans of many runs: scenario, laws, guards, plant, seeds, grid, sample and stopping rule.

The paper's runs, further comparisons, those on the rigid body and every study of a user are a
`Study` each.  Its runs are numbered: points of grid and sample, then laws, then guards, then seeds
(the last change fastest).  A run depends only on its index, not on who makes it or in which order.
"""

import hashlib
import itertools
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.data import data, with_tuples
from wmr_ctrl.core.errors import library
from wmr_ctrl.world.scenario import Scenario, load_scenario, override, scenario_dict

from .intervals import StopRule

Overrides: TypeAlias = Mapping[str, object]
"""Fields of a scenario by key path, such as ``clock.control``."""
LATIN, SOBOL, UNIFORM = "latin-hypercube", "sobol", "uniform"
MOST_SEEDS_EACH = 10_000
"""Seeds of a study that names no number of its own: at most these are asked for."""


@dataclass(frozen=True)
class PlannedCase:
    """Part common to all seeds: scenario (a preset's name, or a Scenario), law, guard, changes.

    ``guard`` None: as the scenario says; ``plant`` "mujoco" is the rigid body.  ``name``: its name
    in tables; ``base``: the group of cases that it is compared in.
    """

    scenario: str | Scenario
    law: str
    guard: bool | None = None
    overrides: Overrides = field(default_factory=dict, hash=False)
    plant: str = "ode"
    name: str = ""
    base: str = ""

    @property
    def labels(self) -> dict[str, object]:
        """Columns that distinguish it from other cases in a table of runs."""
        about = {"case": self.name, "law": self.law, "base": self.base}
        return {**about, "guard": self.guard, "plant": self.plant}

    def overridden(self) -> Scenario:
        """The scenario with the case's overrides.  Raises ScenarioError."""
        switch = {} if self.guard is None else {"guard.enabled": self.guard}
        base = load_scenario(self.scenario) if isinstance(self.scenario, str) else self.scenario
        changed = {**self.overrides, **switch}
        return override(base, changed) if changed else base


class PlannedRun(NamedTuple):
    """A run to make."""

    case: PlannedCase
    seed: int


@dataclass(frozen=True)
class SamplePlan:
    """A sample of a box: method, size, seed, and the range of each key.

    "sobol" makes the n (d + 2) points that Sobol indices need (SALib's scheme of Saltelli).
    """

    method: str
    n: int
    seed: int
    ranges: Mapping[str, tuple[float, float]]

    @cached_property
    def points(self) -> NDArray[np.float64]:
        """The points, one per row, in the order of ``ranges``."""
        low, high = np.array(list(self.ranges.values())).T
        if self.method == SOBOL:
            sampler: Any = library("SALib.sample.sobol", "study")
            rows = sampler.sample(self.problem, self.n, calc_second_order=False, seed=self.seed)
            return np.asarray(rows, dtype=np.float64)
        draw = np.random.Generator(np.random.Philox(self.seed))
        unit = draw.random((self.n, len(low)))
        if self.method == LATIN:
            strata = np.column_stack([draw.permutation(self.n) for _ in low])
            unit = (strata + unit) / self.n
        return low + (high - low) * unit

    @property
    def described(self) -> dict[str, object]:
        """The sample as plain values."""
        ranges = {key: list(pair) for key, pair in self.ranges.items()}
        return {"method": self.method, "n": self.n, "seed": self.seed, "ranges": ranges}

    @property
    def problem(self) -> dict[str, object]:
        """The box in SALib's format."""
        bounds = [list(pair) for pair in self.ranges.values()]
        return {"num_vars": len(bounds), "names": list(self.ranges), "bounds": bounds}


@dataclass(frozen=True)
class Study:
    """Runs of a scenario (a preset's name, or a Scenario).

    ``seeds``: their largest number, from ``first_seed`` on.  ``name``: its name in tables, if it
    changes fields (``overrides``); ``title``: given if the report describes it.  ``laws``: empty
    for all.  ``guards``: whether the guard is on (None: as the scenario says).  ``base``: the group
    that it is compared in.  ``grid`` and ``sample``: values of fields that differ from run to run.
    ``stop``: when a case has enough runs.  ``chunk``: number of runs after which results are
    written.  ``stated``: keys that the plan, or its scenario's file, states.
    """

    scenario: str | Scenario
    seeds: int = MOST_SEEDS_EACH
    name: str = ""
    title: str = ""
    laws: tuple[str, ...] = ()
    overrides: Overrides = field(default_factory=dict, hash=False)
    guards: tuple[bool | None, ...] = (None,)
    base: str = ""
    plant: str = "ode"
    first_seed: int = 0
    grid: Mapping[str, tuple[object, ...]] = field(default_factory=dict, hash=False)
    sample: SamplePlan | None = None
    stop: StopRule | None = None
    figures: tuple[str, ...] = ()
    chunk: int = 1024
    stated: frozenset[str] = frozenset()

    @cached_property
    def loaded(self) -> Scenario:
        """The Scenario.  Raises ScenarioError."""
        return load_scenario(self.scenario) if isinstance(self.scenario, str) else self.scenario

    @property
    def label(self) -> str:
        """Name in tables, claims and figures."""
        given = self.scenario
        return self.name or (given if isinstance(given, str) else given.name)

    def planned(
        self, laws: Sequence[str], seeds: Sequence[int], plant: str = "ode"
    ) -> Iterator[PlannedRun]:
        """Its runs on that plant, for the given laws that it includes and the first seeds."""
        chosen = tuple(law for law in laws if law in (self.laws or laws))
        study = replace(self, laws=chosen, plant=plant)
        for case in map(study.case, range(study.cells)):
            yield from (PlannedRun(case, seed) for seed in seeds[: self.seeds])

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
        """Number of cases, which differ by more than their seed."""
        return self.points * len(self.laws) * len(self.guards)

    @property
    def runs(self) -> int:
        """Number of runs of the whole plan, if no rule stops it."""
        return self.cells * self.seeds

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
        changed = {**self.overrides, **changes}
        which = self.laws[law], self.guards[guard], changed, self.plant
        return PlannedCase(self.scenario, *which, self.label, self.base)

    @cached_property
    def identity(self) -> str:
        """Hash that is equal for two plans if one can continue the other's interrupted work."""
        points = None if self.sample is None else self.sample.points.tobytes().hex()
        text = json.dumps([self.described(), points], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    def described(self) -> dict[str, object]:
        """The plan as plain values, without `chunk`, which does not affect the results."""
        sample = self.sample
        return {
            "scenario": {"name": self.loaded.name, **scenario_dict(self.loaded)},
            "laws": list(self.laws),
            "guard": list(self.guards),
            "plant": self.plant,
            "seeds": {"first": self.first_seed, "count": self.seeds},
            "grid": {key: list(values) for key, values in self.grid.items()},
            "sample": sample and sample.described,
            "stop": self.stop and {**vars(self.stop), "share": self.stop.share},
            "figures": list(self.figures),
        }


def studies_in(package: str, file: str) -> tuple[Study, ...]:
    """Studies of a package's TOML file."""
    return tuple(Study(**with_tuples(row)) for row in data(package, file)["study"])
