"""The plane model beside the robot as a rigid body on tyres: the same cases, laws, seeds on both.

What a robot with tyres ought to do stands in sentences, each judged on the rows of all seeds.

A slope has a key of its own on either plant, since one inclines the ground and the other pulls.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wmr_ctrl.core.data import data, with_tuples
from wmr_ctrl.results import PLANTS, Floats, RunTable
from wmr_ctrl.results.windows import BEFORE, LATE, named
from wmr_ctrl.simulation.batch import Progress
from wmr_ctrl.simulation.campaign.engine import Campaign, run_campaign
from wmr_ctrl.simulation.campaign.plan import Overrides, Study, studies_in

RIGID_SEEDS = (2100, 2101, 2102, 2103, 2104)
"""Seeds that were not used to choose anything about the body."""
_STEEP = math.radians(5.0)
_SLOPE: Mapping[str, Overrides] = {
    "ode": {"slope.angle": _STEEP, "slope.direction": math.pi / 2},
    "mujoco": {"body.slope": _STEEP},
}
AS_PRINTED, SLOPED = "no torque limit, as printed", "slope of 5 degrees, torque limit 10 N m"
TABLES = "tyre_runs.toml"


def _studies(plant: str) -> tuple[Study, ...]:
    """Studies of a plant, with spins and falls first."""
    return tuple(
        replace(one, overrides={**one.overrides, **_SLOPE[plant]}) if one.name == SLOPED else one
        for one in studies_in(__package__, TABLES)
    )


RIGID_STUDIES: Mapping[str, tuple[Study, ...]] = {plant: _studies(plant) for plant in PLANTS}
"""Studies of all cases on each plant."""
E1_BEFORE, E1 = f"e1_rms_{named(BEFORE)}", f"e1_rms_{named(LATE)}"
COMPARED = ("ise_total", E1_BEFORE, E1, "limit_ratio", "slipped", "tipped")
"""Figures of the comparison."""


def run_rigid_comparison(
    seeds: Sequence[int] = RIGID_SEEDS,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Campaign:
    """Every case, law and seed on both plants; ``progress`` is told each plant's share.

    Whole runs are those on tyres.  Raises MissingExtraError without the extra physics.
    """
    done = []
    for plant in PLANTS:
        laws = ("pid", "smc", "mb", "nn", "prox")
        plan = [run for study in RIGID_STUDIES[plant] for run in study.planned(laws, seeds, plant)]
        done.append(run_campaign(plan, jobs, progress, COMPARED, plant == "mujoco"))
    plane, body = (one.table for one in done)
    both = {name: np.concatenate([plane[name], body[name]]) for name in plane}
    return Campaign(RunTable(both), done[-1].runs)


MUJOCO = "mujoco"


@dataclass(frozen=True)
class RigidClaim:
    """Claim for a law: whether it holds in every run, with least and greatest number."""

    text: str
    law: str
    holds: bool
    numbers: str


@dataclass(frozen=True)
class _Expected:
    """A number of each run on tyres that lies between two bounds, or is expected to.

    ``of``, one of `NUMBERS`, takes it from a run and the run of the same seed in the case and plant
    ``beside`` (none: the run itself).
    """

    text: str
    laws: tuple[str, ...]
    case: str
    of: str
    unit: str = ""
    beside: tuple[str, str] | None = None
    least: float = float("-inf")
    most: float = float("inf")

    def numbers(self, rows: RunTable, law: str) -> list[float]:
        """Bounded number for each seed; NaN if a run has none."""
        case, plant = self.beside or (self.case, MUJOCO)
        mine = rows.where(case=self.case, law=law, plant=MUJOCO)
        others = rows.where(case=case, law=law, plant=plant)
        _, here, there = np.intersect1d(mine["seed"], others["seed"], return_indices=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            numbers = NUMBERS[self.of](mine.at(here), others.at(there))
        return np.where(np.isfinite(numbers), numbers, np.nan).tolist()


def rigid_claims(rows: RunTable) -> tuple[RigidClaim, ...]:
    """Judge each claim for each of its laws that was run."""
    return tuple(
        _judged(claim, law, numbers)
        for claim in (_Expected(**with_tuples(row)) for row in data(__package__, TABLES)["claim"])
        for law in claim.laws
        if (numbers := claim.numbers(rows, law))
    )


def _judged(claim: _Expected, law: str, numbers: Sequence[float]) -> RigidClaim:
    """Verdict, least and greatest number, and number of runs that have one."""
    count, known = len(numbers), [number for number in numbers if not math.isnan(number)]
    if not known:
        return RigidClaim(claim.text, law, False, f"none in {count} runs")
    holds = len(known) == count and all(claim.least < n < claim.most for n in known)
    low, high = (f"{value:.3g}" for value in (min(known), max(known)))
    both = low if low == high else f"{low} to {high}"
    few = "" if len(known) == count else f" in {len(known)} of {count} runs"
    return RigidClaim(claim.text, law, holds, f"{both}{claim.unit}{few}")


NUMBERS: Mapping[str, Callable[[RunTable, RunTable], Floats]] = {
    "ise apart": lambda rows, others: 100 * np.abs(rows["ise_total"] / others["ise_total"] - 1),
    "late e1 apart": lambda rows, others: 1e3 * np.abs(rows[E1] - others[E1]),
    "late e1": lambda rows, _: 1e3 * rows[E1],
    "growth": lambda rows, _: rows[E1] / rows[E1_BEFORE],
    "tipped": lambda rows, _: rows["tipped"],
    "upright": lambda rows, _: np.where(np.isnan(rows["tipped"]), rows["limit_ratio"], np.nan),
}
"""Distance of two ISE [%] and of two late e1 [mm], late e1 [mm] and its growth, time of the fall
[s], and largest |v|/limit of a run that stays up."""
