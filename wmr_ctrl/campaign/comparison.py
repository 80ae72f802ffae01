"""Beyond the paper: every law with and without the guard, one factor at a time around two bases.

Both bases are the paper's simulation with its noise cut at 3 standard deviations; one holds the
torque for 10 ms, the other for 100 ms.  The seeds were not used to choose anything.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from types import MappingProxyType

import numpy as np

from wmr_ctrl.campaign.engine import (
    Overrides,
    PhaseProgress,
    PlannedCase,
    Refusal,
    Silent,
    run_cases,
)
from wmr_ctrl.results import Outcome, Run, distance, ise, tau_peak, window
from wmr_ctrl.sim.batch import check_jobs

SCENARIO = "paper-simulation"
OUR_LAWS = ("pid", "smc", "mb", "nn", "prox", "kanayama")
HELD_OUT = (300, 301, 302)
"""Seeds that no gain and no bound was chosen with."""

BASES = MappingProxyType({"10 ms": 0.01, "100 ms": 0.1})
"""Control periods of the two base cases [s]."""

BASE, FAR_START, OUTSIDE, PUSHED = "base", "far start", "start outside", "adversary"
"""Factors that the report speaks of by name."""

REFUSED = "refused"
"""Outcome of a case whose bounds the guard cannot meet."""

BEFORE, AFTER = (30.0, 40.0), (70.0, 80.0)
"""Windows [s] before and after the change of parameters."""

ADVERSARY: Overrides = MappingProxyType(
    {
        "robot.m": 25.0,
        "robot.I": 2.7,
        "robot.mu": 0.0,
        "model.m": 50.0,
        "model.I": 5.4,
        "model.mu": 0.08,
        "changes": [],
        "disturbance.std": 0.0,
        "disturbance.push": [60.0, 15.0],
        "guard.M_min": [25.0, 2.7],
        "guard.M_max": [70.0, 7.5],
    }
)
"""Half the believed mass, no friction, and a push of dbar that always drives on."""

FAR: Overrides = MappingProxyType({"initial.pose": [-5.0, -5.0, -0.7]})
DROP: Overrides = MappingProxyType(
    {
        "changes": [{"t": 3.0, "m": 25.0, "I": 2.7, "mu": 0.0}],
        "guard.M_min": [22.5, 2.43],
        "guard.M_max": [55.0, 5.94],
    }
)
"""What drops, and masses around it for the guard."""

AS_A_ROBOT: Overrides = MappingProxyType(
    {
        "encoder.counts": 1024,
        "gyro.enabled": True,
        "gyro.bias": 0.005,
        "gyro.noise": 0.01,
        "actuator.tau_max": 10.0,
        "actuator.lag": 0.02,
        "actuator.jitter": 0.005,
        "wheels.radius": [0.02, 0.02],
    }
)
"""Encoders differenced over a period, a gyro, late and lagging drives, radii 2 % off."""

FACTORS: Mapping[str, Overrides] = MappingProxyType(
    {
        BASE: {},
        FAR_START: FAR,
        "far start, friction believed 50 % too high": {**FAR, "model.mu": 0.12},
        "far start, mass and friction drop at 3 s": {**FAR, **DROP},
        OUTSIDE: {"initial.velocity": [1.3, 2.0]},
        PUSHED: ADVERSARY,
        "lemniscate": {"reference.kind": "lemniscate"},
        "stop and go": {"reference.kind": "stop-and-go"},
        "rounded square": {"reference.kind": "rounded-square"},
        "T = 1 ms": {"clock.control": 0.001},
        "T = 20 ms": {"clock.control": 0.02},
        "T = 50 ms": {"clock.control": 0.05},
        "tau_max = 20 N m": {"actuator.tau_max": 20.0},
        "tau_max = 10 N m": {"actuator.tau_max": 10.0},
        "tau_max = 6.5 N m": {"actuator.tau_max": 6.5},
        "tau_max = 5 N m": {"actuator.tau_max": 5.0},
        "as a robot has it": AS_A_ROBOT,
    }
)
"""What one case changes against its base, by the case's name."""


@dataclass(frozen=True, slots=True)
class ComparisonCase:
    """One run of the comparison: base and factor name the case, ``overrides`` make it."""

    base: str
    factor: str
    law: str
    guard: bool
    seed: int
    overrides: Overrides = field(hash=False)

    @property
    def planned(self) -> PlannedCase:
        """What it shares with the cases of other seeds."""
        return PlannedCase(SCENARIO, self.law, self.guard, self.overrides)


def comparison_plan(
    laws: Sequence[str] = OUR_LAWS,
    seeds: Sequence[int] = HELD_OUT,
    bases: Sequence[str] = tuple(BASES),
    factors: Sequence[str] = tuple(FACTORS),
) -> tuple[ComparisonCase, ...]:
    """All cases; a factor that sets the period belongs to the first base only."""
    return tuple(
        ComparisonCase(base, factor, law, guard, seed, overrides_of(base, factor))
        for base in bases
        for factor in factors
        if "clock.control" not in FACTORS[factor] or base == next(iter(BASES))
        for law in laws
        for guard in (False, True)
        for seed in seeds[: 1 if factor == PUSHED else None]
    )


def overrides_of(base: str, factor: str) -> dict[str, object]:
    """Fields of ``paper-simulation`` that a case changes."""
    common = {"clock.control": BASES[base], "disturbance.truncate": 3.0}
    return {**common, **FACTORS[factor]}


def swept(key: str) -> list[tuple[float, str]]:
    """The numbers that factors give to the field ``key`` alone, each with its factor's name."""
    alone = ((changed, factor) for factor, changed in FACTORS.items() if len(changed) == 1)
    pairs = ((changed.get(key), factor) for changed, factor in alone)
    return [(value, factor) for value, factor in pairs if isinstance(value, float)]


@dataclass(frozen=True, slots=True)
class ComparedRun:
    """One case: outcome ("refused" where the guard's bounds cannot be met) and its figures.

    ``position_rms``, ``position_max``: RMS and largest distance from its place over 70-80 s [m].
    ``ise`` [m2 s + rad2 s]; ``e1_before``, ``e1_after``: mean |e1| [m] over 30-40 s and 70-80 s;
    ``tau_peak`` [N m]; ``speed`` (2): largest |v_i|/v_u1_i; ``clipped`` (2): share of samples in
    which the guard acted, for guarded runs.  None where a run has none.  ``refusal``: the guard's
    words where it refused.
    """

    case: ComparisonCase
    outcome: str
    violations: int = 0
    speed: tuple[float, float] | None = None
    position_rms: float | None = None
    position_max: float | None = None
    ise: float | None = None
    e1_before: float | None = None
    e1_after: float | None = None
    tau_peak: float | None = None
    clipped: tuple[float, float] | None = None
    refusal: str = ""

    @property
    def broke(self) -> bool:
        """Whether the run left a velocity limit; leaving the guard's bounds is not that."""
        return self.outcome in (Outcome.LIMIT_VIOLATED, Outcome.DIVERGED, Outcome.NON_FINITE)


def compared_run(case: ComparisonCase, run: Run) -> ComparedRun:
    """The row of a finished run."""
    ratios = tuple(v / u for v, u in zip(run.monitor.max_abs_v, run.settings.v_u1, strict=True))
    clipped = run["clip_active"].mean(axis=0) if run.guard and run.rows else None
    return ComparedRun(
        case,
        run.outcome.value,
        run.monitor.violations,
        (ratios[0], ratios[1]),
        *_distances(run, *AFTER),
        ise(run)["total"],
        _mean_e1(run, *BEFORE),
        _mean_e1(run, *AFTER),
        tau_peak(run),
        None if clipped is None else (float(clipped[0]), float(clipped[1])),
    )


def _distances(run: Run, start: float, end: float) -> tuple[float | None, float | None]:
    rows = window(run, start, end)
    if rows is None:
        return None, None
    gap = distance(run)[rows]
    return float(np.sqrt(np.mean(gap**2))), float(gap.max())


def _mean_e1(run: Run, start: float, end: float) -> float | None:
    rows = window(run, start, end)
    return None if rows is None else float(np.mean(np.abs(run["e"][rows, 0])))


@dataclass(frozen=True)
class GuardComparison:
    """All rows in the plan's order, asked by base, case, law and guard; empty if it was not run."""

    rows: tuple[ComparedRun, ...] = ()

    @property
    def bases(self) -> tuple[str, ...]:
        """Base cases, in order."""
        return tuple(dict.fromkeys(row.case.base for row in self.rows))

    @property
    def laws(self) -> tuple[str, ...]:
        """Laws, in order."""
        return tuple(dict.fromkeys(row.case.law for row in self.rows))

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds, from the least to the greatest."""
        return tuple(sorted({row.case.seed for row in self.rows}))

    def factors(self, base: str | None = None) -> tuple[str, ...]:
        """Cases of a base (None: of any), in order."""
        return tuple(dict.fromkeys(r.case.factor for r in self.rows if base in (None, r.case.base)))

    def of(self, base: str, factor: str, law: str, guard: bool) -> tuple[ComparedRun, ...]:
        """The runs of one case, one per seed."""
        wanted = (base, factor, law, guard)
        return tuple(r for r in self.rows if _place(r.case) == wanted)

    def median(self, figure: str, base: str, factor: str, law: str, guard: bool) -> float | None:
        """Median of a `ComparedRun`'s figure over the runs that have it; None if none has."""
        return median(map(attrgetter(figure), self.of(base, factor, law, guard)))

    def guarded(self, guard: bool = True) -> Iterator[ComparedRun]:
        """Runs with the guard, or without it, that were not refused."""
        return (r for r in self.rows if r.case.guard is guard and r.outcome != REFUSED)


def median(values: Iterable[float | None]) -> float | None:
    """Median of the values that are there; None if none is."""
    there = [value for value in values if value is not None]
    return float(statistics.median(there)) if there else None


def _place(case: ComparisonCase) -> tuple[str, str, str, bool]:
    return case.base, case.factor, case.law, case.guard


def run_comparison(
    plan: Sequence[ComparisonCase],
    jobs: int | None = None,
    progress: PhaseProgress | None = None,
) -> GuardComparison:
    """Compile and run ``plan``, two phases of ``progress``.

    A guard's refusal becomes a row; that of an unguarded case is raised.  Results do not depend on
    ``jobs``.
    """
    check_jobs(jobs)

    def row(place: int, run: Run) -> ComparedRun:
        return compared_run(plan[place], run)

    what = "the laws with and without the guard"
    texts = f"Compiling {what}", f"Running {what}"
    runs = [(case.planned, case.seed) for case in plan]
    rows = run_cases(runs, row, jobs, progress or Silent(), texts)
    return GuardComparison(
        tuple(
            ComparedRun(case, REFUSED, refusal=item.text) if isinstance(item, Refusal) else item
            for case, item in zip(plan, rows, strict=True)
        )
    )
