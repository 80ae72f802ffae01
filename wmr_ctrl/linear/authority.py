"""How hard the barrier can pull, and what a constant disturbance does against it.

The pull of a law rises from nothing at v_c1, peaks, and falls back to nothing at the limit: beyond
the peak nothing holds.  The largest disturbance that the loop resists is therefore an exact number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from wmr_ctrl.linear.loop import closed_loop
from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.linear.point import Point
from wmr_ctrl.linear.velocity import pull_of
from wmr_ctrl.scenario import Scenario

GRID = 600


@dataclass(frozen=True)
class Authority:
    """Largest outward force [N or N m] resisted from v = v_c1, and the velocity of that peak."""

    force: float
    speed: float


def authority(scenario: Scenario, law: str, axis: int, v_c0: float) -> Authority:
    """Largest constant outward disturbance of ``axis`` (0, 1) that its barrier resists.

    ``v_c0`` [m/s or rad/s] stays, the model is right, and v starts at v_c1 and moves outwards.
    """
    pull = _axis_pull(scenario, law, axis, v_c0)
    sign = -1.0 if v_c0 < 0 else 1.0
    u1, u2 = scenario.limits.v_u1[axis], scenario.limits.v_u2[axis]
    grid = _outwards(min(abs(v_c0), u2), u1, u2)
    held = -sign * np.asarray(pull(sign * grid))
    best = int(held.argmax())
    left, right = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
    peak = minimize_scalar(
        lambda v: sign * float(pull(sign * v)), bounds=(left, right), method="bounded",
        options={"xatol": 1e-12},
    )  # fmt: skip
    if -peak.fun > held[best]:
        return Authority(float(-peak.fun), float(sign * peak.x))
    return Authority(float(held[best]), float(sign * grid[best]))


def settled_speed(
    scenario: Scenario, law: str, axis: int, v_c0: float, force: float
) -> float | None:
    """Velocity at which a constant outward ``force`` [N or N m] is balanced; None: too large."""
    top = authority(scenario, law, axis, v_c0)
    if force >= top.force:
        return None
    pull = _axis_pull(scenario, law, axis, v_c0)
    sign = -1.0 if v_c0 < 0 else 1.0

    def rest(v: float) -> float:
        return -sign * float(pull(sign * v)) - force

    inner = min(abs(v_c0), scenario.limits.v_u2[axis])
    return float(sign * brentq(rest, inner, abs(top.speed), xtol=1e-14))


def linear_offset(
    scenario: Scenario, law: str, axis: int, force: float, point: Point | None = None
) -> Floats:
    """Offset of (e1, e2, e3, v1, omega) that the linear loop settles to under a constant force."""
    loop = closed_loop(scenario, law, point)
    gain = np.atleast_2d(np.asarray(loop.dcgain()))
    return np.asarray(gain[:5, axis] * force, dtype=float)


def pull_curve(scenario: Scenario, law: str, axis: int, v_c0: float, speeds: Floats) -> Floats:
    """Force [N] or moment [N m] of the law over ``speeds`` (N,), its friction term taken off."""
    return np.asarray(_axis_pull(scenario, law, axis, v_c0)(speeds))


def _axis_pull(
    scenario: Scenario, law: str, axis: int, v_c0: float
) -> Callable[[float | Floats], Floats]:
    asked = np.zeros(2)
    asked[axis] = v_c0
    return pull_of(scenario, law, axis, asked)


def _outwards(start: float, u1: float, u2: float) -> Floats:
    """Speeds from ``start`` to the limit, dense near the limit, with u2 from both sides."""
    near = u1 - (u1 - start) * np.linspace(0, 1, GRID)[1:] ** 2
    return np.unique(np.concatenate((near, [u2 * (1 - 1e-12), u2, u2 * (1 + 1e-12)])))
