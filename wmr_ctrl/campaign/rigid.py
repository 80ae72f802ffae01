"""The plane model beside the robot as a rigid body on tyres: the same cases, laws, seeds on both.

What a robot with tyres ought to do stands in sentences, each judged on the rows of all seeds.

A slope has a key of its own on either plant, since one inclines the ground and the other pulls.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from wmr_ctrl.campaign.engine import Campaign, PhaseProgress, run_campaign
from wmr_ctrl.campaign.plan import Overrides, Study
from wmr_ctrl.campaign.table import FigureTable
from wmr_ctrl.results import PLANTS
from wmr_ctrl.results.windows import BEFORE, LATE, named

RIGID_SEEDS = (2100, 2101, 2102, 2103, 2104)
"""Seeds with which nothing about the body was chosen."""

_LIMIT: Overrides = MappingProxyType({"actuator.tau_max": 10.0})
_STEEP = math.radians(5.0)
_SLOPE: Mapping[str, Overrides] = {
    "ode": {"slope.angle": _STEEP, "slope.direction": math.pi / 2},
    "mujoco": {"body.slope": _STEEP},
}


AS_PRINTED, LIMITED = "no torque limit, as printed", "torque limit 10 N m"
ENCODERS = "encoders of 4096 counts, no torque limit"
GUARDED, SLOPED = (
    "guard with alpha = 5/s, no torque limit",
    "slope of 5 degrees, torque limit 10 N m",
)
STEPS = {h: f"plant step of {1e3 * h:g} ms, torque limit 10 N m" for h in (5e-4, 2e-3)}
OURS_TOO = ("mb", "nn", "prox")


def _studies(plant: str) -> tuple[Study, ...]:
    """From what spins and falls to what does not."""
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
    return Campaign(FigureTable(row for one in done for row in one.table), done[-1].runs)


MUJOCO, ODE = "mujoco", "ode"
Worst: TypeAlias = Callable[[FigureTable, str], list[float | None]]
"""The number that a claim bounds, a seed each; None where a run has none."""


@dataclass(frozen=True, slots=True)
class RigidClaim:
    """A sentence and a law: whether it holds in every run, and the numbers, least and greatest."""

    text: str
    law: str
    holds: bool
    numbers: str


@dataclass(frozen=True, slots=True)
class _Expected:
    """A number of each run that lies between two bounds, or is expected to."""

    text: str
    laws: tuple[str, ...]
    of: Worst
    least: float = float("-inf")
    most: float = float("inf")
    unit: str = ""


def rigid_claims(rows: FigureTable) -> tuple[RigidClaim, ...]:
    """Each sentence for each of its laws that was run."""
    return tuple(_judged(rows))


def _judged(rows: FigureTable) -> Iterator[RigidClaim]:
    for claim in _CLAIMS:
        for law in claim.laws:
            numbers = claim.of(rows, law)
            known = [number for number in numbers if number is not None]
            if not numbers:
                continue
            holds = len(known) == len(numbers) and all(
                claim.least < number < claim.most for number in known
            )
            yield RigidClaim(claim.text, law, holds, _span(known, len(numbers), claim.unit))


def _span(known: Sequence[float], count: int, unit: str) -> str:
    """Least and greatest number, and how many runs have one."""
    if not known:
        return f"none in {count} runs"
    low, high = (f"{value:.3g}" for value in (min(known), max(known)))
    both = low if low == high else f"{low} to {high}"
    few = "" if len(known) == count else f" in {len(known)} of {count} runs"
    return f"{both}{unit}{few}"


def _pairs(
    figure: str, rows: FigureTable, law: str, one: tuple[str, str], other: tuple[str, str]
) -> Iterator[tuple[float | None, float | None]]:
    """A figure of one seed in two cases on two plants."""
    known = {row.seed: row[figure] for row in rows.of(other[0], law, plant=other[1])}
    mine = rows.of(one[0], law, plant=one[1])
    return ((row[figure], known[row.seed]) for row in mine if row.seed in known)


def _ise_apart(one: tuple[str, str], other: tuple[str, str]) -> Worst:
    """Distance of two ISE as a share of the second [%]."""

    def of(rows: FigureTable, law: str) -> list[float | None]:
        pairs = _pairs("ise_total", rows, law, one, other)
        return [100 * abs(a / b - 1) if a and b else None for a, b in pairs]

    return of


def _e1_apart(rows: FigureTable, law: str) -> list[float | None]:
    """Distance of the late e1 on tyres from that of the plane model [mm]."""
    pairs = _pairs(E1, rows, law, *_SAME)
    return [None if a is None or b is None else 1e3 * abs(a - b) for a, b in pairs]


def _growth(rows: FigureTable, law: str) -> list[float | None]:
    """e1 after the change of parameters over that before."""
    errors = ((row[E1], row[E1_BEFORE]) for row in rows.of(LIMITED, law, plant=MUJOCO))
    return [after / before if after and before else None for after, before in errors]


def _on_slope(rows: FigureTable, law: str) -> list[float | None]:
    """Late e1 on the slope [mm]."""
    errors = (row[E1] for row in rows.of(SLOPED, law, plant=MUJOCO))
    return [None if error is None else 1e3 * error for error in errors]


def _fall(rows: FigureTable, law: str) -> list[float | None]:
    """When it fell [s]."""
    return [row["tipped"] for row in rows.of(AS_PRINTED, law, plant=MUJOCO)]


def _ratio(case: str) -> Worst:
    """Largest velocity over its limit of runs that stay up."""

    def of(rows: FigureTable, law: str) -> list[float | None]:
        runs = rows.of(case, law, plant=MUJOCO)
        return [None if row["tipped"] else row["limit_ratio"] for row in runs]

    return of


_SAME = ((LIMITED, MUJOCO), (LIMITED, ODE))
_CLAIMS = (
    _Expected("With 10 N m the ISE is within 5 % of the plane model’s", OURS_TOO,
              _ise_apart(*_SAME), most=5.0, unit=" %"),
    _Expected("With 10 N m the late e₁ is within 0.2 mm of the plane model’s", OURS_TOO,
              _e1_apart, most=0.2, unit=" mm"),
    _Expected("After the change e₁ is more than 10 times that before", ("mb",), _growth,
              least=10.0),
    _Expected("After the change e₁ is less than 3 times that before", ("nn",), _growth,
              most=3.0),
    _Expected("As printed, without a torque limit, the robot falls over", ("mb", "nn"), _fall,
              unit=" s"),
    _Expected("With encoders it stays up and within its limits", OURS_TOO, _ratio(ENCODERS),
              most=1.0, unit=" of the limit"),
    _Expected("With a torque limit of 10 N m it stays up and within its limits", OURS_TOO,
              _ratio(LIMITED), most=1.0, unit=" of the limit"),
    _Expected("With the guard’s bound of acceleration it stays up and within its limits", OURS_TOO,
              _ratio(GUARDED), most=1.0, unit=" of the limit"),
    _Expected("On a slope of 5 degrees e₁ is above 5 mm", ("mb",), _on_slope, least=5.0,
              unit=" mm"),
    _Expected("On a slope of 5 degrees e₁ is below 2 mm", ("nn", "prox"), _on_slope, most=2.0,
              unit=" mm"),
    *(
        _Expected(f"With plant steps of {1e3 * h:g} ms the ISE is within 1 % of that with 1 ms",
                  OURS_TOO, _ise_apart((name, MUJOCO), (LIMITED, MUJOCO)), most=1.0, unit=" %")
        for h, name in STEPS.items()
    ),
)  # fmt: skip
"""What is asked of every seed."""
