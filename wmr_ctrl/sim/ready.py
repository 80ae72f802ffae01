"""A law on a scenario, compiled and ready to run."""

from __future__ import annotations

from dataclasses import dataclass

from wmr_ctrl.compiled import CompiledLoop
from wmr_ctrl.results import Settings
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.finish import settings_of

Pair = tuple[float, float]


@dataclass(frozen=True)
class Ready:
    """A compiled loop, its scenario and law, and what a guard assumes of the motion.

    ``bounds``: largest disturbance and force [N, N m], as in `sim.finish.finished`.
    """

    compiled: CompiledLoop
    scenario: Scenario
    law: str
    bounds: tuple[Pair, Pair]

    @property
    def settings(self) -> Settings:
        """Clocks, limits and windows of the scenario."""
        return settings_of(self.scenario)
