"""A law on a scenario, compiled and ready to run."""

from __future__ import annotations

from dataclasses import dataclass

from wmr_ctrl.compiled import CompiledLoop
from wmr_ctrl.results import Assumptions, Settings
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.finish import settings_of


@dataclass(frozen=True)
class RunnableLoop:
    """A compiled loop, its scenario and law, and what a guard assumes of the motion."""

    compiled: CompiledLoop
    scenario: Scenario
    law: str
    bounds: Assumptions

    @property
    def settings(self) -> Settings:
        """Clocks, limits and windows of the scenario."""
        return settings_of(self.scenario)
