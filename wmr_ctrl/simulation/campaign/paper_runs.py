"""Runs of the paper's Sections V and VI: which scenarios, with which laws, over which seeds."""

from collections.abc import Mapping, Sequence

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.problems import show
from wmr_ctrl.results.windows import WINDOWS, named

from .plan import MOST_SEEDS_EACH, Overrides, PlannedRun, Study

PAPER_LAWS = ("pid", "smc", "mb", "nn")
"""The four laws of the paper's Sections V and VI, in its order."""
BARRIER_LAWS = ("mb", "nn")
"""The laws that Theorems 1 and 2 are about."""
QUICK_SEEDS = 3
"""Seeds of a campaign that is only to be seen working."""
FEW = 5
"""Seeds of a study whose result hardly depends on the noise."""
IDEAL = "paper-simulation-nominal"
"""Neither noise nor a change, and a model that is exact: what Theorems 1 and 2 assume."""
FARTHER: Overrides = {"initial.pose": [-20.0, 10.0, 2.0]}
_FAST: Overrides = {"initial.velocity": [0.99, -1.485]}
_STARTS: Mapping[str, tuple[str, Overrides]] = {
    "as-stated": ("the paper's start", {}),
    "as-stated-fast-start": ("a start at 0.99 of both limits", _FAST),
    "as-stated-far-start": ("the far start", {"initial.pose": [-5.0, -5.0, -0.7]}),
    "as-stated-farther-start": ("a start 22 m away", FARTHER),
}
_FINE: Overrides = {"clock.control": 1e-4, "clock.plant": 1e-4, "clock.duration": 2.0}
"""Nearly continuous time: a tenth of it changes the fifth digit of |v|/limit."""


def _as_stated(name: str, start: str, overrides: Overrides) -> Study:
    title = f"The theorems' own case, from {start}: no noise, the exact model, samples of 0.1 ms"
    return Study(IDEAL, 1, name, title, BARRIER_LAWS, {**_FINE, **overrides})


AS_STATED = tuple(_STARTS)
"""Names of the studies that come as near to the theorems' hypotheses as a simulation can."""
STUDIES = (
    Study("paper-simulation"),
    Study("paper-simulation-no-switch"),
    Study("paper-simulation-noise-free", seeds=1),
    Study(IDEAL, seeds=1),
    Study("paper-experiment"),
    Study("paper-experiment-literal", seeds=FEW),
    Study("far-start"),
    Study("far-start-friction-overestimated"),
    Study("far-start-drop"),
    Study("outside-start", seeds=FEW),
    Study("fast-reference", seeds=FEW),
    *(_as_stated(name, *start) for name, start in _STARTS.items()),
    Study(
        IDEAL,
        1,
        "farther-start-1ms",
        "A start 22 m away: no noise, the exact model, samples of 1 ms",
        BARRIER_LAWS,
        {**FARTHER, "clock.control": 1e-3, "clock.plant": 1e-3, "clock.duration": 5.0},
    ),
)
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
