"""Comparison beyond the paper: every law with and without the guard, one factor at a time around
two bases.

Both bases are the paper's simulation with its noise cut at 3 standard deviations; one holds the
torque for 10 ms, the other for 100 ms.  The seeds were not used to choose anything.
"""

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType

from wmr_ctrl.core.data import data
from wmr_ctrl.results import RunTable
from wmr_ctrl.results.windows import BEFORE, LATE, named
from wmr_ctrl.simulation.batch import Progress
from wmr_ctrl.simulation.campaign.engine import run_campaign
from wmr_ctrl.simulation.campaign.plan import MOST_SEEDS_EACH, Overrides, PlannedRun, Study

SCENARIO = "paper-simulation"
OUR_LAWS = ("pid", "smc", "mb", "nn", "prox", "kanayama")
HELD_OUT = (300, 301, 302)
"""Seeds that were not used to choose gains or bounds."""
BASES = MappingProxyType({"10 ms": 0.01, "100 ms": 0.1})
"""Control periods of the two base cases [s]."""
BASE, FAR_START, OUTSIDE, PUSHED = "base", "far start", "start outside", "adversary"
"""Names of factors that figures and tests use."""


def _factors() -> Iterator[tuple[str, Overrides]]:
    table = data(__package__, "guard_runs.toml")
    for name, changed in table.items():
        yield name, {**table.get(changed.pop("with", ""), {}), **changed}


FACTORS: Mapping[str, Overrides] = MappingProxyType(dict(_factors()))
"""Changes of a case relative to its base, by the case's name; ``with`` adds those of another."""


def comparison_plan(
    laws: Sequence[str] = OUR_LAWS,
    seeds: Sequence[int] = HELD_OUT,
    bases: Sequence[str] = tuple(BASES),
    factors: Sequence[str] = tuple(FACTORS),
) -> tuple[PlannedRun, ...]:
    """All runs; a factor that sets the period belongs to the first base only."""
    studies = (
        Study(
            SCENARIO,
            1 if factor == PUSHED else MOST_SEEDS_EACH,
            factor,
            overrides=overrides_of(base, factor),
            guards=(False, True),
            base=base,
        )
        for base in bases
        for factor in factors
        if "clock.control" not in FACTORS[factor] or base == next(iter(BASES))
    )
    return tuple(run for study in studies for run in study.planned(laws, seeds))


def overrides_of(base: str, factor: str) -> dict[str, object]:
    """Fields of ``paper-simulation`` that a case changes."""
    common = {"clock.control": BASES[base], "disturbance.truncate": 3.0}
    return {**common, **FACTORS[factor]}


def swept(key: str) -> list[tuple[float, str]]:
    """Values of factors that change the field ``key`` alone, each with its factor's name."""
    alone = ((changed, factor) for factor, changed in FACTORS.items() if len(changed) == 1)
    pairs = ((changed.get(key), factor) for changed, factor in alone)
    return [(value, factor) for value, factor in pairs if isinstance(value, float)]


_OVER = named(LATE)
AWAY, FARTHEST, E1 = f"d_rms_{_OVER}", f"d_max_{_OVER}", f"e1_mean_{_OVER}"
E1_BEFORE = f"e1_mean_{named(BEFORE)}"
COMPARED = ("violations", "limit_ratio1", "limit_ratio2", AWAY, FARTHEST, "ise_total", E1_BEFORE,
            E1, "tau_peak", "guard_share1", "guard_share2")  # fmt: skip
"""Figures of the comparison."""


def run_comparison(
    plan: Sequence[PlannedRun], jobs: int | None = None, progress: Progress | None = None
) -> RunTable:
    """The rows of ``plan``; as `run_campaign`."""
    return run_campaign(plan, jobs, progress, COMPARED, False).table
