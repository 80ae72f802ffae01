"""How far the linear picture reaches: its deviation from the nonlinear loop against amplitude."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control as ct
import numpy as np

from wmr_ctrl.linear.loop import closed_loop
from wmr_ctrl.linear.numbers import Floats, bisect
from wmr_ctrl.linear.point import Point, settled
from wmr_ctrl.linear.stepper import Course, Stepper, stepper
from wmr_ctrl.scenario import Scenario

LEVELS = (0.01, 0.1, 1.0)
"""Deviations of interest: 1, 10 and 100 %."""

FORWARD, SIDEWAYS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


@dataclass(frozen=True)
class Comparison:
    """Linear and nonlinear loop from one resting point, same sampling, same start."""

    point: Point
    nonlinear: Stepper
    linear: ct.StateSpace
    duration: float

    def responses(self, e: Floats) -> tuple[Course, Floats]:
        """Nonlinear run and linear e (N, 3), from the resting point displaced by ``e`` (3)."""
        start = self.point.s + np.concatenate((e, np.zeros(2)))
        course = self.nonlinear.run(start, self.duration)
        return course, self.point.e + self.linear_errors(e)

    def linear_errors(self, e: Floats) -> Floats:
        """Linear response (N, 3) to a displacement ``e`` (3)."""
        count = round(self.duration / self.nonlinear.period)
        state = np.zeros(self.linear.nstates)
        state[:3] = e
        rows = np.empty((count, 3))
        for k in range(count):
            rows[k] = state[:3]
            state = self.linear.A @ state
        return rows

    def deviation(self, e: Floats) -> float:
        """RMS distance of the two positions (e1, e2), over the RMS linear excursion."""
        course, linear = self.responses(np.asarray(e, dtype=float))
        apart = np.linalg.norm((course.e - linear)[:, :2])
        found = float(apart / np.linalg.norm((linear - self.point.e)[:, :2]))
        return found if math.isfinite(found) else math.inf


def comparison(
    scenario: Scenario, law: str, duration: float = 20.0, memory: str = "frozen"
) -> Comparison:
    """Both loops of ``law`` around where it settles, sampled with the scenario's clock."""
    point = settled(scenario, law)
    linear = closed_loop(scenario, law, point, scenario.clock.control, memory)
    return Comparison(point, stepper(scenario, law, point, memory=memory), linear, duration)


def reach(
    given: Comparison,
    direction: tuple[float, float, float] = FORWARD,
    levels: tuple[float, ...] = LEVELS,
    between: tuple[float, float] = (1e-3, 5.0),
) -> dict[float, float | None]:
    """Smallest amplitude [m] at which the deviation passes each level; None if not up to 5 m."""
    grid = np.geomspace(*between, 38)
    found = np.array([given.deviation(a * np.array(direction)) for a in grid])
    return {level: _passing(given, direction, grid, found, level) for level in levels}


def _passing(
    given: Comparison,
    direction: tuple[float, float, float],
    grid: Floats,
    found: Floats,
    level: float,
) -> float | None:
    above = np.flatnonzero(found > level)
    if not above.size:
        return None
    if above[0] == 0:
        return float(grid[0])
    low, high = grid[above[0] - 1], grid[above[0]]
    return bisect(
        lambda a: given.deviation(a * np.array(direction)) <= level, float(low), float(high), 1e-3
    )
