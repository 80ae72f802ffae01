"""A law on a scenario, compiled for many runs at a time."""

from __future__ import annotations

from dataclasses import dataclass

from wmr_ctrl.results import Settings
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.finish import settings_of
from wmr_ctrl.sim.native import Kernels

Pair = tuple[float, float]


@dataclass(frozen=True)
class Ready:
    """Kernels for lanes, scenario, law, and what a guard assumes of the motion.

    ``bounds``: largest disturbance and force [N, N m], as in `sim.finish.finished`.
    """

    kernels: Kernels
    scenario: Scenario
    law: str
    bounds: tuple[Pair, Pair]

    @property
    def settings(self) -> Settings:
        """Clocks, limits and windows of the scenario."""
        return settings_of(self.scenario)
