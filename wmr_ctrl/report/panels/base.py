"""What a panel is, and what panels ask of the runs that they show."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from wmr_ctrl.report.canvas import Margins, Place
from wmr_ctrl.results import Run
from wmr_ctrl.scenario import loads_scenario

Group: TypeAlias = Mapping[str, Run]
"""Runs of one scenario by law, in the order in which they are drawn and named."""

Draw: TypeAlias = Callable[[Place, Group, Margins], None]


@dataclass(frozen=True, slots=True)
class Panel:
    """One panel: its letter in the paper, a name for files, a title, and what draws it.

    ``laws`` restricts it to laws that have what it shows (None: all).
    """

    letter: str
    key: str
    title: str
    draw: Draw
    laws: tuple[str, ...] | None = None

    def of(self, group: Group) -> Group:
        """The runs of ``group`` that this panel shows."""
        return {law: run for law, run in group.items() if self.laws is None or law in self.laws}


def switch_time(run: Run) -> float | None:
    """When the robot's parameters change [s], as the run's scenario says; None if they do not."""
    text = run.provenance.get("scenario_toml")
    if not text:
        return None
    changes = loads_scenario(text).changes
    return changes[0].t if changes else None
