"""One-step safety at the barrier: the longest hold that cannot jump across either limit."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize_scalar

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.linear.sampled import for_own_period
from wmr_ctrl.linear.velocity import pull_of
from wmr_ctrl.scenario import Scenario

GRID = 400


def one_step_period(scenario: Scenario, law: str, v_c0: Floats | None = None) -> Floats | None:
    """Longest period (2) [s] after which no |v| < v_u1 has left the limit, v_c0 (2) held still.

    The worst v of each axis; v_c0 defaults to the start's.  Friction is taken as compensated.  None
    for a law that does not know the limit, inf where no hold is too long.
    """
    loop = Loop(scenario, law)
    if not loop.uses("limits."):
        return None
    asked = loop.start.v_c0 if v_c0 is None else np.asarray(v_c0, dtype=float)

    def limit(other: Scenario) -> Floats:
        return np.array([_shortest(other, law, axis, asked) for axis in range(2)])

    return for_own_period(scenario, law, limit)


def _shortest(scenario: Scenario, law: str, axis: int, v_c0: Floats) -> float:
    pull, u1 = pull_of(scenario, law, axis, v_c0), scenario.limits.v_u1[axis]
    mass = (scenario.robot.m, scenario.robot.I)[axis]

    def crossing(v: float) -> float:
        """Time to reach the limit that the force points to, at the acceleration it has now."""
        acceleration = float(pull(v)) / mass
        return (u1 - math.copysign(1.0, acceleration) * v) / max(abs(acceleration), 1e-300)

    return smallest(crossing, u1, scenario.limits.v_u2[axis])


def smallest(of: Callable[[float], float], u1: float, u2: float) -> float:
    """Smallest value of ``of(v)`` over |v| < u1, with the kinks at +-u2 taken from both sides."""
    inside = u1 * (1 - 1e-6)
    tiny = 1e-12 * u1
    grid = np.unique(np.concatenate((np.linspace(-inside, inside, GRID), _sides(u2, tiny))))
    found = np.array([of(float(v)) for v in grid])
    best = int(found.argmin())
    left, right = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    polished = minimize_scalar(of, bounds=(left, right), method="bounded", options={"xatol": 1e-10})
    return float(min(found[best], polished.fun))


def _sides(u2: float, tiny: float) -> Floats:
    return np.array([sign * u2 + side * tiny for sign in (-1, 1) for side in (-1, 0, 1)])
