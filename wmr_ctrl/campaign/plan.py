"""Which scenarios are run, with which laws, over which seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from wmr_ctrl.campaign.engine import PlannedCase
from wmr_ctrl.errors import ArgumentError

PAPER_LAWS = ("pid", "smc", "mb", "nn")
"""The four laws of the paper's Sections V and VI, in its order."""

QUICK_SEEDS = 3
"""Seeds of a campaign that is only to be seen working."""

FEW = 5
"""Seeds of a study whose result hardly depends on the noise."""


@dataclass(frozen=True, slots=True)
class Study:
    """A scenario to be run with every law, over at most ``seeds`` seeds (None: all of them)."""

    scenario: str
    seeds: int | None = None


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """One run to be made."""

    scenario: str
    law: str
    seed: int

    @property
    def case(self) -> PlannedCase:
        """What it shares with the runs of other seeds."""
        return PlannedCase(self.scenario, self.law)


STUDIES = (
    Study("paper-simulation"),
    Study("paper-simulation-no-switch"),
    Study("paper-simulation-noise-free", seeds=1),
    Study("paper-simulation-nominal", seeds=1),
    Study("paper-experiment"),
    Study("paper-experiment-literal", seeds=FEW),
    Study("far-start"),
    Study("far-start-friction-overestimated"),
    Study("far-start-drop"),
    Study("outside-start", seeds=FEW),
    Study("fast-reference", seeds=FEW),
)
"""What Sections V and VI need, their controls, and the cases in which the theorems end."""


def paper_plan(
    laws: Sequence[str] = PAPER_LAWS, seeds: int = 20, first_seed: int = 0
) -> tuple[PlannedRun, ...]:
    """All runs of :data:`STUDIES`, the first seeds of every study and law before the others.

    The seeds are ``first_seed``, ``first_seed`` + 1, ...  Raises ArgumentError for fewer than one
    seed, a negative one, or a law given twice.
    """
    if seeds < 1 or first_seed < 0:
        raise ArgumentError(
            f"seeds = {seeds!r} from {first_seed!r} on: give at least one seed, from 0 up."
        )
    if len(set(laws)) != len(laws):
        raise ArgumentError(f"laws = {', '.join(laws)}: name each law once.")
    return tuple(
        PlannedRun(study.scenario, law, first_seed + offset)
        for offset in range(seeds)
        for study in STUDIES
        if study.seeds is None or offset < study.seeds
        for law in laws
    )
