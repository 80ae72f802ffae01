"""Runs of the paper's Sections V and VI: which scenarios, with which laws, over which seeds."""

from collections.abc import Sequence

from wmr_ctrl.core.errors import ArgumentError, show
from wmr_ctrl.results.windows import WINDOWS, named

from .plan import MOST_SEEDS_EACH, PlannedRun, studies_in

PAPER_LAWS = ("pid", "smc", "mb", "nn")
"""The four laws of the paper's Sections V and VI, in its order."""
BARRIER_LAWS = ("mb", "nn")
"""The laws that Theorems 1 and 2 are about."""
QUICK_SEEDS = 3
"""Seeds for a quick campaign that only shows that everything runs."""
STUDIES = studies_in(__package__, "paper_runs.toml")
"""Runs for Sections V and VI, their controls, the theorems as stated, and their ends."""


def paper_plan(
    laws: Sequence[str] = PAPER_LAWS, seeds: int = 20, first_seed: int = 0
) -> tuple[PlannedRun, ...]:
    """All runs of :data:`STUDIES`, the first seeds of every study and law before the others.

    The seeds are ``first_seed``, ``first_seed`` + 1, ...  Raises ArgumentError for fewer than one
    seed, a negative one, or a law given twice.
    """
    if not 1 <= seeds <= MOST_SEEDS_EACH or first_seed < 0:
        raise ArgumentError(
            f"seeds = {show(seeds)} from {first_seed!r} on: give 1 to {MOST_SEEDS_EACH} seeds, the "
            "first at least 0."
        )
    if len(set(laws)) != len(laws):
        raise ArgumentError(f"laws = {', '.join(laws)}: name each law once.")
    numbered = range(first_seed, first_seed + seeds)
    runs = [run for study in STUDIES for run in study.planned(laws, numbered)]
    return tuple(sorted(runs, key=lambda run: run.seed))


_WINDOWS = tuple(map(named, WINDOWS))
REPORTED = (
    "position_rms", "position_rms_last_quarter", "position_max", "d_start",
    *(f"d_rms_{span}" for span in _WINDOWS), "halving_time", "settling_time",
    "ise_total", "ise_before", "ise_after", "ise_position", "ise_orientation",
    *(f"e{axis}_rms_{span}" for axis in (1, 2, 3) for span in _WINDOWS),
    "max_abs_v1", "max_abs_omega", "limit_ratio", "violated", "violations", "first_violation",
    "tau_peak", "tau_peak_late", "tau_rms", "V1_start", "V1_late", "V1_rises", "V1_rise_share",
    "W1_end", "W1_largest", "W2_end", "W2_largest",
)  # fmt: skip
"""Figures of the report's tables, in their order."""
