"""The plane model beside the robot as a rigid body on tyres: the same cases, laws, seeds on both.

What a robot with tyres ought to do stands in sentences, each judged on the rows of all seeds.

A slope has a key of its own on either plant, since one inclines the ground and the other pulls.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.results import PLANTS, Floats
from wmr_ctrl.results.table import RunTable
from wmr_ctrl.results.windows import BEFORE, LATE, named

from .engine import Campaign, PhaseProgress, run_campaign
from .plan import Overrides, Study

RIGID_SEEDS = (2100, 2101, 2102, 2103, 2104)
"""Seeds with which nothing about the body was chosen."""
_LIMIT: Overrides = {"actuator.tau_max": 10.0}
_STEEP = math.radians(5.0)
_SLOPE: Mapping[str, Overrides] = {
    "ode": {"slope.angle": _STEEP, "slope.direction": math.pi / 2},
    "mujoco": {"body.slope": _STEEP},
}

AS_PRINTED, LIMITED = "no torque limit, as printed", "torque limit 10 N m"
ENCODERS = "encoders of 4096 counts, no torque limit"
GUARDED = "guard with alpha = 5/s, no torque limit"
SLOPED = "slope of 5 degrees, torque limit 10 N m"
STEPS = {h: f"plant step of {1e3 * h:g} ms, torque limit 10 N m" for h in (5e-4, 2e-3)}
OURS_TOO = ("mb", "nn", "prox")


def _studies(plant: str) -> tuple[Study, ...]:
    """Studies, spins and falls first."""
    paper, steady = "paper-simulation", "paper-simulation-no-switch"
    guarded = {"guard.alpha": 5.0, "disturbance.truncate": 3.0}
    ours = [
        (ENCODERS, paper, {"encoder.counts": 4096}),
        (LIMITED, paper, _LIMIT),
        *((name, paper, {**_LIMIT, "clock.plant": h}) for h, name in STEPS.items()),
        (GUARDED, steady, guarded),
        (SLOPED, steady, {**_LIMIT, **_SLOPE[plant]}),
    ]
    return (
        Study(paper, name=AS_PRINTED, laws=("pid", "smc", "mb", "nn")),
        *(
            Study(
                preset,
                name=name,
                laws=OURS_TOO,
                overrides=changes,
                guards=(True if name == GUARDED else None,),
            )
            for name, preset, changes in ours
        ),
    )


RIGID_STUDIES: Mapping[str, tuple[Study, ...]] = {plant: _studies(plant) for plant in PLANTS}
"""The cases on each plant."""
E1_BEFORE, E1 = f"e1_rms_{named(BEFORE)}", f"e1_rms_{named(LATE)}"
COMPARED = ("ise_total", E1_BEFORE, E1, "limit_ratio", "slipped", "tipped")
"""Figures of the comparison."""


def run_rigid_comparison(
    seeds: Sequence[int] = RIGID_SEEDS,
    jobs: int | None = None,
    progress: PhaseProgress | None = None,
) -> Campaign:
    """Every case, law and seed on both plants, each two phases of ``progress``.

    Whole runs are those on tyres.  Raises MissingExtraError without the extra physics.
    """
    done = []
    for plant in PLANTS:
        laws = ("pid", "smc", "mb", "nn", "prox")
        plan = [run for study in RIGID_STUDIES[plant] for run in study.planned(laws, seeds, plant)]
        name = "on tyres" if plant == "mujoco" else "on the plane model"
        texts = f"Compiling the laws {name}", f"Running the laws {name}"
        done.append(run_campaign(plan, jobs, progress, COMPARED, plant == "mujoco", texts))
    plane, body = (one.table for one in done)
    both = {name: np.concatenate([plane[name], body[name]]) for name in plane}
    return Campaign(RunTable(both), done[-1].runs)


MUJOCO, ODE = "mujoco", "ode"


@dataclass(frozen=True)
class RigidClaim:
    """A sentence and a law: whether it holds in every run, and the numbers, least and greatest."""

    text: str
    law: str
    holds: bool
    numbers: str


@dataclass(frozen=True)
class _Expected:
    """A number of each run on tyres that lies between two bounds, or is expected to.

    ``of`` takes it from a run and the run of the same seed in the case and plant ``beside`` (none:
    the run itself).
    """

    text: str
    laws: tuple[str, ...]
    case: str
    of: Callable[[RunTable, RunTable], Floats]
    unit: str = ""
    beside: tuple[str, str] | None = None
    least: float = float("-inf")
    most: float = float("inf")

    def numbers(self, rows: RunTable, law: str) -> list[float]:
        """The number that is bounded, a seed each; NaN where a run has none."""
        case, plant = self.beside or (self.case, MUJOCO)
        mine = rows.where(case=self.case, law=law, plant=MUJOCO)
        others = rows.where(case=case, law=law, plant=plant)
        _, here, there = np.intersect1d(mine["seed"], others["seed"], return_indices=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            numbers = self.of(mine.at(here), others.at(there))
        return np.where(np.isfinite(numbers), numbers, np.nan).tolist()


def rigid_claims(rows: RunTable) -> tuple[RigidClaim, ...]:
    """Each sentence for each of its laws that was run."""
    return tuple(
        _judged(claim, law, numbers)
        for claim in _CLAIMS
        for law in claim.laws
        if (numbers := claim.numbers(rows, law))
    )


def _judged(claim: _Expected, law: str, numbers: Sequence[float]) -> RigidClaim:
    """The verdict, with least and greatest number, and how many runs have one."""
    count, known = len(numbers), [number for number in numbers if not math.isnan(number)]
    if not known:
        return RigidClaim(claim.text, law, False, f"none in {count} runs")
    holds = len(known) == count and all(claim.least < n < claim.most for n in known)
    low, high = (f"{value:.3g}" for value in (min(known), max(known)))
    both = low if low == high else f"{low} to {high}"
    few = "" if len(known) == count else f" in {len(known)} of {count} runs"
    return RigidClaim(claim.text, law, holds, f"{both}{claim.unit}{few}")


def _ise_apart(rows: RunTable, others: RunTable) -> Floats:
    """Distance of two ISE as a share of the second [%]."""
    return 100 * np.abs(rows["ise_total"] / others["ise_total"] - 1)


def _growth(rows: RunTable, _: RunTable) -> Floats:
    """e1 after the change of parameters over that before."""
    return rows[E1] / rows[E1_BEFORE]


def _stays_up(text: str, case: str) -> _Expected:
    def ratio(rows: RunTable, _: RunTable) -> Floats:
        return np.where(np.isnan(rows["tipped"]), rows["limit_ratio"], np.nan)

    words = f"{text} it stays up and within its limits"
    return _Expected(words, OURS_TOO, case, ratio, " of the limit", most=1.0)


def _late_e1(rows: RunTable, _: RunTable) -> Floats:
    return 1e3 * rows[E1]


_PLANE, _BODY = (LIMITED, ODE), (LIMITED, MUJOCO)
_ISE = "With 10 N m the ISE is within 5 % of the plane model’s"
_LATE = "With 10 N m the late e₁ is within 0.2 mm of the plane model’s"
_GROWN = "After the change e₁ is more than 10 times that before"
_LEARNT = "After the change e₁ is less than 3 times that before"
_FALLS = "As printed, without a torque limit, the robot falls over"
_UPHILL = "On a slope of 5 degrees e₁ is {} mm"
_STEP = "With plant steps of {:g} ms the ISE is within 1 % of that with 1 ms"
_CLAIMS = (
    _Expected(_ISE, OURS_TOO, LIMITED, _ise_apart, " %", _PLANE, most=5.0),
    _Expected(
        _LATE, OURS_TOO, LIMITED, lambda a, b: 1e3 * np.abs(a[E1] - b[E1]), " mm", _PLANE, most=0.2
    ),
    _Expected(_GROWN, ("mb",), LIMITED, _growth, least=10.0),
    _Expected(_LEARNT, ("nn",), LIMITED, _growth, most=3.0),
    _Expected(_FALLS, ("mb", "nn"), AS_PRINTED, lambda rows, _: rows["tipped"], " s"),
    _stays_up("With encoders", ENCODERS),
    _stays_up("With a torque limit of 10 N m", LIMITED),
    _stays_up("With the guard’s bound on acceleration", GUARDED),
    _Expected(_UPHILL.format("above 5"), ("mb",), SLOPED, _late_e1, " mm", least=5.0),
    _Expected(_UPHILL.format("below 2"), ("nn", "prox"), SLOPED, _late_e1, " mm", most=2.0),
    *(
        _Expected(_STEP.format(1e3 * h), OURS_TOO, name, _ise_apart, " %", _BODY, most=1.0)
        for h, name in STEPS.items()
    ),
)
"""Claims on every seed."""
