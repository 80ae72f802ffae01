"""Plan of a search for gains: law, scenario, seeds, length, and what is made small."""

import math
from dataclasses import dataclass

from wmr_ctrl.errors import ArgumentError, UnknownNameError
from wmr_ctrl.fields.problems import show
from wmr_ctrl.laws.law import Law
from wmr_ctrl.laws.registry import LAWS
from wmr_ctrl.scenario import Scenario

MOST_TRIALS = 100_000
TRACKING, CORRIDOR = MERITS = ("tracking", "corridor")
MEASURED = {TRACKING: "position_rms", CORRIDOR: "corridor"}
"""Figure that each merit makes small, as the objective has it."""


@dataclass(frozen=True, kw_only=True)
class TuningPlan:
    """Law, scenario, seeds and length of a search; ``weight`` in m per N m.

    ``hold``: keys of gains that stay as they are, such as those that several laws share;
    ``merit``: one of `MERITS`, what is made small beside the torques' change.
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
        """Raise ArgumentError for what cannot be meant."""
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
        unknown = [key for key in self.hold if key not in tunable(LAWS[self.law])]
        if unknown or not self.searched:
            raise ArgumentError(
                f"hold = {', '.join(self.hold)}: a search for {self.law} varies "
                f"{', '.join(tunable(LAWS[self.law]))}; hold some of these, but not all."
            )

    @property
    def searched(self) -> tuple[str, ...]:
        """Keys of the gains that are searched; of Eq. (7) the law's own, where there are such."""
        own = f"gains.{self.law}.kinematics"
        stated = self.scenario.gains.get(self.law, {}).get("kinematics") is not None
        keys = (key for key in tunable(LAWS[self.law]) if key not in self.hold)
        return tuple(own if stated and key == "gains.kinematics.k" else key for key in keys)


def tunable(law: Law) -> tuple[str, ...]:
    """Keys of the gains that are searched: the law's own, then those of Eq. (7) if it has it."""
    own = tuple(f"gains.{law.name}.{name}" for name in law.tuned)
    return (*own, "gains.kinematics.k") if own and law.traits.auxiliary else own
