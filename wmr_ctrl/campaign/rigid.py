"""The plane model beside the robot as a rigid body on tyres: the same cases, laws, seeds on both.

A slope has a key of its own on either plant, since one inclines the ground and the other pulls.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from wmr_ctrl.campaign.engine import (
    Overrides,
    PhaseProgress,
    PlannedCase,
    Refusal,
    Silent,
    run_cases,
)
from wmr_ctrl.results import PLANTS, Run, e_rms, ise

EARLY, LATE = (30.0, 40.0), (70.0, 80.0)
"""Windows of the error before and long after the change of parameters [s]."""

RIGID_SEEDS = (2100, 2101, 2102, 2103, 2104)
"""Seeds with which nothing about the body was chosen."""

_STEADY = "paper-simulation-no-switch"
_LIMIT: Overrides = MappingProxyType({"actuator.tau_max": 10.0})
_STEEP = math.radians(5.0)
_UPHILL = {"slope.angle": _STEEP, "slope.direction": math.pi / 2}


@dataclass(frozen=True, slots=True)
class RigidCase:
    """A case: a preset with ``changes``, and what else the plane model or the body needs."""

    name: str
    preset: str
    laws: tuple[str, ...]
    guard: bool | None = None
    changes: Overrides = field(default_factory=dict, hash=False)
    own: Mapping[str, Overrides] = field(default_factory=dict, hash=False)

    def planned(self, law: str, plant: str) -> PlannedCase:
        """What the seeds of a law share on a plant."""
        changes = {**self.changes, **self.own.get(plant, {})}
        return PlannedCase(self.preset, law, self.guard, changes, plant)


AS_PRINTED, LIMITED = "no torque limit, as printed", "torque limit 10 N m"
ENCODERS = "encoders of 4096 counts, no torque limit"
GUARDED, SLOPED = (
    "guard with alpha = 5/s, no torque limit",
    "slope of 5 degrees, torque limit 10 N m",
)
STEPS = {h: f"plant step of {1e3 * h:g} ms, torque limit 10 N m" for h in (5e-4, 2e-3)}
OURS_TOO = ("mb", "nn", "prox")
RIGID_CASES = (
    RigidCase(AS_PRINTED, "paper-simulation", ("pid", "smc", "mb", "nn")),
    RigidCase(ENCODERS, "paper-simulation", OURS_TOO, None, {"encoder.counts": 4096}),
    RigidCase(LIMITED, "paper-simulation", OURS_TOO, None, _LIMIT),
    *(
        RigidCase(name, "paper-simulation", OURS_TOO, None, {**_LIMIT, "clock.plant": h})
        for h, name in STEPS.items()
    ),
    RigidCase(
        GUARDED,
        _STEADY,
        OURS_TOO,
        True,
        {"guard.alpha": 5.0, "disturbance.truncate": 3.0},
    ),
    RigidCase(
        SLOPED,
        _STEADY,
        OURS_TOO,
        None,
        _LIMIT,
        {"ode": _UPHILL, "mujoco": {"body.slope": _STEEP}},
    ),
)
"""From what spins and falls to what does not."""


@dataclass(frozen=True, slots=True)
class RigidRow:
    """A run: ISE [m2 s + rad2 s], RMS of e1 over 70-80 s [m], largest |v|/limit; None: has none.

    ``slipped``, ``tipped``: when [s], None if never, or on the plane model.
    """

    case: str
    law: str
    seed: int
    plant: str
    outcome: str
    ise: float | None
    e1_before: float | None
    e1: float | None
    ratio: float
    slipped: float | None
    tipped: float | None


@dataclass(frozen=True)
class RigidComparison:
    """All rows, and the whole runs of the first seed by (case, law, plant); empty if not run."""

    rows: tuple[RigidRow, ...] = ()
    runs: Mapping[tuple[str, str, str], Run] = field(default_factory=dict)

    def of(self, case: str, law: str, plant: str) -> tuple[RigidRow, ...]:
        """A row per seed."""
        wanted = (case, law, plant)
        return tuple(row for row in self.rows if (row.case, row.law, row.plant) == wanted)


def rigid_row(case: str, plant: str, run: Run) -> RigidRow:
    """The row of a finished run."""
    seen = run.monitor.rigid
    before, late = (errors and errors[0] for errors in (e_rms(run, *EARLY), e_rms(run, *LATE)))
    pairs = zip(run.monitor.max_abs_v, run.settings.v_u1, strict=True)
    return RigidRow(
        case, run.law, run.seed, plant, run.outcome.value, ise(run)["total"],
        before, late, max(v / limit for v, limit in pairs),
        seen.slipped if seen else None, seen.tipped if seen else None,
    )  # fmt: skip


def run_rigid_comparison(
    seeds: Sequence[int] = RIGID_SEEDS,
    cases: Sequence[RigidCase] = RIGID_CASES,
    jobs: int | None = None,
    progress: PhaseProgress | None = None,
) -> RigidComparison:
    """Every case, law and seed on both plants, each two phases of ``progress``.

    Raises MissingExtraError without the extra physics.
    """
    rows: list[RigidRow] = []
    whole: dict[tuple[str, str, str], Run] = {}
    for plant in PLANTS:
        plan = [(case, law, seed) for case in cases for law in case.laws for seed in seeds]

        def kept(place: int, run: Run, plan: Sequence[tuple[RigidCase, str, int]] = plan,
                 plant: str = plant) -> RigidRow:  # fmt: skip
            case, law, seed = plan[place]
            if seed == seeds[0]:
                whole[case.name, law, plant] = run
            return rigid_row(case.name, plant, run)

        name = "on tyres" if plant == "mujoco" else "on the plane model"
        texts = f"Compiling the laws {name}", f"Running the laws {name}"
        runs = [(case.planned(law, plant), seed) for case, law, seed in plan]
        results = run_cases(runs, kept, jobs, progress or Silent(), texts)
        rows += [row for row in results if not isinstance(row, Refusal)]
    return RigidComparison(tuple(rows), MappingProxyType(whole))
