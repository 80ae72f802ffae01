"""Sampled data: spectral radius against the control period, and the largest stable one.

The limits without learning are those of the warnings before a run (`wmr_ctrl.checks`); this module
adds the loops whose weights move, and the barrier's one-step limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.sample_time import kink_limits
from wmr_ctrl.checks.sampled_loop import LONGEST, SHORTEST
from wmr_ctrl.checks.sampled_loop import largest_stable_period as largest_stable_period
from wmr_ctrl.linear.blocks import PERIOD
from wmr_ctrl.linear.loop import closed_matrix, law_at, plant_at
from wmr_ctrl.linear.numbers import Floats, bisect, radius
from wmr_ctrl.linear.point import Point, on_reference
from wmr_ctrl.scenario import Clock, Metrics, Scenario

MARGIN, RATIO = 1e-9, 1.15


def spectral_radius(
    scenario: Scenario,
    law: str,
    periods: Iterable[float],
    point: Point | None = None,
    memory: str = "frozen",
) -> Floats:
    """Spectral radius of the sampled closed loop for each control period [s]: stable below 1."""
    of = radius_of(scenario, law, point, memory)
    return np.array([of(float(period)) for period in periods])


def radius_of(
    scenario: Scenario, law: str, point: Point | None = None, memory: str = "frozen"
) -> Callable[[float], float]:
    """Spectral radius as a function of the period [s], at ``point`` (default: on the reference)."""
    at = on_reference(scenario, law) if point is None else point

    def of(period: float) -> float:
        moving = plant_at(scenario, at, period)
        return radius(closed_matrix(moving, law_at(scenario, law, at, period, memory)))

    return of


def largest_learning_period(scenario: Scenario, law: str, point: Point | None = None) -> float:
    """Supremum of the stable periods [s] with weights and estimates moving; 0.0 if there is none.

    Linearised at ``point`` (default: on the reference with the start's weights); inf if every
    period up to 10 s is stable.
    """
    return supremum(radius_of(scenario, law, point, "learning"))


def supremum(
    of: Callable[[float], float],
    shortest: float = SHORTEST,
    ratio: float = RATIO,
    rtol: float = 1e-7,
) -> float:
    """Largest period up to which the spectral radius ``of(period)`` stays at or below 1."""
    below, period = 0.0, shortest
    while of(period) <= 1 + MARGIN:
        if period >= LONGEST:
            return math.inf
        below, period = period, period * ratio
    return bisect(lambda t: of(t) <= 1 + MARGIN, below, period, rtol) if below else 0.0


def kink_periods(scenario: Scenario, law: str) -> Floats | None:
    """Longest stable period (2) [s] where v sits at v_u2 with v_c0 beyond; None without a barrier.

    At the kink the rate of the velocity loop is rho instead of rho/2: 2/rho for mb.  inf where a
    law adapts its gains to its period such that no period is too long.
    """
    loop = Loop(scenario, law)
    if not loop.uses("limits."):
        return None
    return for_own_period(scenario, law, lambda other: kink_limits(Loop(other, law)))


def for_own_period(scenario: Scenario, law: str, limit: Callable[[Scenario], Floats]) -> Floats:
    """Limits (2) [s] of the period that hold when the law itself runs at that period.

    Where the law's force does not depend on the period that is ``limit(scenario)``.
    """
    if not Loop(scenario, law).uses(PERIOD):
        return limit(scenario)

    def share(axis: int) -> Callable[[float], float]:
        return lambda period: period / float(limit(at_period(scenario, period))[axis])

    return np.array([supremum(share(axis), shortest=1e-3, ratio=2.0, rtol=1e-3) for axis in (0, 1)])


def at_period(scenario: Scenario, period: float) -> Scenario:
    """The scenario with control period ``period`` [s], on a clock of its own."""
    drives = replace(scenario.actuator, delay=0.0)
    sensor = replace(scenario.sensor, pose_period=0.0)
    clock = Clock(period, period, 100 * period)
    return replace(
        scenario, clock=clock, actuator=drives, sensor=sensor, metrics=Metrics(), changes=()
    )
