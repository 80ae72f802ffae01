"""The search behind tuning: its plan, and CMA-ES over logarithms of gains."""

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.control.laws.law import Law
from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError, library, show
from wmr_ctrl.results import Floats
from wmr_ctrl.world.scenario import Scenario

MOST_TRIALS = 100_000
TRACKING, CORRIDOR = MERITS = ("tracking", "corridor")
MEASURED = {TRACKING: "position_rms", CORRIDOR: "corridor"}
"""Figure that each merit makes small, as the objective has it."""


@dataclass(frozen=True, kw_only=True)
class TuningPlan:
    """Law, scenario, seeds and length of a search; ``weight`` in m per N m.

    ``hold``: keys of gains that are not changed, such as those that several laws share; ``merit``:
    one of `MERITS`, the quantity to minimise besides the torques' change.
    """

    scenario: Scenario
    law: str
    seeds: tuple[int, ...] = (1, 2, 3)
    test_seeds: tuple[int, ...] = (7101, 7102, 7103, 7104, 7105)
    trials: int = 200
    weight: float = 1e-3
    hold: tuple[str, ...] = ()
    merit: str = TRACKING

    def __post_init__(self) -> None:
        """Raise ArgumentError for invalid values."""
        if not self.seeds or not self.test_seeds:
            raise ArgumentError("seeds: give at least one for training and one for testing.")
        shared = sorted(set(self.seeds) & set(self.test_seeds))
        if shared:
            raise ArgumentError(
                f"seeds: {shared[0]} serves training and test alike, so the test would flatter. "
                "Give ranges that have no seed in common."
            )
        if not 1 <= self.trials <= MOST_TRIALS:
            raise ArgumentError(f"trials = {show(self.trials)} must be from 1 to {MOST_TRIALS}.")
        if self.merit not in MERITS:
            raise UnknownNameError("merit", self.merit, MERITS)
        if not (self.weight >= 0 and math.isfinite(self.weight)):
            raise ArgumentError(f"weight = {self.weight} must be finite and not negative.")
        if not tunable(LAWS[self.law]):
            raise ArgumentError(
                f"the law {self.law!r} names no gains to be tuned: list them in its `tuned`."
            )
        if wrong := [k for k in self.hold if k not in (*tunable(LAWS[self.law]), *self._keys)]:
            raise ArgumentError(
                f"hold: {', '.join(map(show, wrong))} would not change anyway; a search for "
                f"{self.law} varies {', '.join(self._keys)}. Hold some of these."
            )
        if not self.searched:
            raise ArgumentError(
                f"hold = {', '.join(self.hold)}: these are all gains that a search for {self.law} "
                "varies. Leave at least one out."
            )

    @property
    def searched(self) -> tuple[str, ...]:
        """Keys of the searched gains."""
        pairs = zip(tunable(LAWS[self.law]), self._keys, strict=True)
        return tuple(key for shared, key in pairs if not {shared, key} & {*self.hold})

    @property
    def _keys(self) -> tuple[str, ...]:
        """Keys of `tunable` gains; the law's own k of Eq. (7) if it has one."""
        own = f"gains.{self.law}.kinematics"
        stated = self.scenario.gains.get(self.law, {}).get("kinematics") is not None
        keys = tunable(LAWS[self.law])
        return tuple(own if stated and key == "gains.kinematics.k" else key for key in keys)


def tunable(law: Law) -> tuple[str, ...]:
    """Keys of the gains that can be searched: the law's own, and those of Eq. (7) if it uses it."""
    own = tuple(f"gains.{law.name}.{name}" for name in law.tuned)
    return (*own, "gains.kinematics.k") if own and law.traits.auxiliary else own


SPREAD = 0.4
"""First step of the search, in logarithms."""
WIDEST = 3.4
"""Bound of the search, in logarithms."""
DIGITS = 4
"""Digits of a gain."""


@dataclass(frozen=True, order=True)
class Cost:
    """Cost of a set of gains; entries are compared in this order.

    ``refused``: a requested corridor does not exist; ``lost``: number of runs that ended early;
    ``metres``: the objective of the other runs [m].
    """

    refused: bool
    lost: int
    metres: float

    @property
    def sentence(self) -> str:
        """The cost as text."""
        ended = f", {self.lost} of the runs ended early" if self.lost else ""
        return f"{1e3 * self.metres:.4g} mm{' without a corridor' if self.refused else ''}{ended}"


class Search:
    """CMA-ES over the logarithms of gains relative to the start's; deterministic for a plan."""

    def __init__(self, start: Mapping[str, Sequence[float]]) -> None:
        """Search from gains by key, all positive; raises MissingExtraError without cma."""
        self.start, size = start, sum(map(len, start.values()))
        draws = np.random.RandomState(size)  # cma asks for this kind; nothing global is touched
        options = {
            "bounds": [-WIDEST, WIDEST], "verbose": -9, "seed": math.nan, "randn": draws.randn,
            "CMA_diagonal": 0, "tolfun": 0, "tolfunhist": 0, "tolx": 0, "tolstagnation": 10**9,
            "tolflatfitness": 10**9,
        }  # fmt: skip
        self._engine = library("cma", "tune").CMAEvolutionStrategy(np.zeros(size), SPREAD, options)
        self.tried = 0
        self._best = Cost(True, sys.maxsize, math.inf), np.zeros(size)

    def ask(self) -> list[Floats]:
        """Candidates of the next generation; the start is one of the first ones."""
        asked = [np.asarray(item, dtype=float) for item in self._engine.ask()]
        if self.tried == 0:
            asked[0] = np.zeros_like(asked[0])
        return asked

    def tell(self, candidates: Sequence[Floats], costs: Sequence[Cost]) -> None:
        """Process the candidates' costs, of which only the order matters."""
        different = sorted(set(costs))
        self._engine.tell(list(candidates), [float(different.index(cost)) for cost in costs])
        least = min(costs)
        if least < self._best[0]:
            self._best = least, candidates[costs.index(least)]
        self.tried += len(candidates)

    def gains(self, logarithms: Floats) -> dict[str, tuple[float, ...]]:
        """Gains by key, rounded to their printed digits."""
        factors, scaled_by_key = iter(np.exp(logarithms)), {}
        for key, values in self.start.items():
            scaled = (value * next(factors) for value in values)
            scaled_by_key[key] = tuple(float(f"{number:.{DIGITS}g}") for number in scaled)
        return scaled_by_key

    def best(self) -> dict[str, tuple[float, ...]]:
        """The gains with the least cost."""
        return self.gains(self._best[1])
