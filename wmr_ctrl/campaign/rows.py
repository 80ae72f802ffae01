"""One run, reduced to plain numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wmr_ctrl.campaign.figures import figures_of
from wmr_ctrl.results import Run


@dataclass(frozen=True, slots=True)
class Row:
    """A run without its log: ``values`` maps each figure's name to its number, None if none."""

    scenario: str
    law: str
    seed: int
    outcome: str
    values: Mapping[str, float | None]


def row_of(run: Run) -> Row:
    """The run's labels, outcome and figures."""
    return Row(run.scenario, run.law, run.seed, run.outcome.value, figures_of(run))
