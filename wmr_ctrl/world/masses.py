"""Mass and inertia that a guard counts on: stated, or what the laws believe, widened."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Scenario

Pair = tuple[float, float]


def mass_bounds(scenario: Scenario) -> tuple[Pair, Pair]:
    """Smallest and largest mass and inertia [kg, kg m2], before what effects add to them.

    guard.M_min and guard.M_max; where one is not stated, model.m and model.I, narrowed or widened
    by the share guard.mass_margin.  Of the true robot and its changes nothing is read.
    """
    guard = scenario.guard
    (m,), (inertia,) = scenario.value("model.m"), scenario.value("model.I")
    low, high = 1.0 - guard.mass_margin, 1.0 + guard.mass_margin
    least, most = (low * m, low * inertia), (high * m, high * inertia)
    return guard.M_min or least, guard.M_max or most


def heaviest(scenario: Scenario) -> float:
    """Largest mass that a guard counts on [kg]."""
    return mass_bounds(scenario)[1][0]
