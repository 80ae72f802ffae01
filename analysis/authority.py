"""What a barrier resists: the largest constant force, and describing functions.

The pull of a law rises from nothing at v_c1, peaks, and falls back to nothing at the limit: beyond
the peak nothing holds.  The largest disturbance that the loop resists is therefore an exact number.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import control as ct
import numpy as np
from scipy.optimize import brentq

from wmr_ctrl.theory.linear import closed_loop
from wmr_ctrl.theory.linear.linearise import Floats, Point, lowest
from wmr_ctrl.theory.linear.sampled import pull_of
from wmr_ctrl.world.scenario import Scenario


def dead_zone(scenario: Scenario) -> Floats:
    """|v_c0| from v_u2 to v_u2 + 1/(v_u1 - v_u2), per axis (2, 2): v_c1 = v_u2 there."""
    u1, u2 = np.array(scenario.limits.v_u1), np.array(scenario.limits.v_u2)
    return np.stack((u2, u2 + 1 / (u1 - u2)), axis=1)


GRID = 600


def _axis_pull(
    scenario: Scenario, law: str, axis: int, v_c0: float
) -> Callable[[float | Floats], Floats]:
    asked = np.zeros(2)
    asked[axis] = v_c0
    return pull_of(scenario, law, axis, asked)


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
    # Dense near the limit, with u2 from both sides.
    near = u1 - (u1 - min(abs(v_c0), u2)) * np.linspace(0, 1, GRID)[1:] ** 2
    grid = np.unique(np.concatenate((near, [u2 * (1 - 1e-12), u2, u2 * (1 + 1e-12)])))
    speed, least = lowest(lambda v: sign * np.asarray(pull(sign * v)), grid, 1e-12)
    return Authority(-least, sign * speed)


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


class BarrierTerm(ct.DescribingFunctionNonlinearity):
    """The term sgn(v) h(v)/(u1 - |v|) of Eq. (10): nothing up to u2, a jump of 1/(u1 - u2), a pole.

    Its describing function has a closed form; it is 0 up to amplitude u2 and diverges at u1.
    """

    def __init__(self, u1: float, u2: float) -> None:
        """Limit ``u1`` and start ``u2`` of the barrier [m/s or rad/s]."""
        super().__init__()
        self.u1, self.u2 = u1, u2

    def __call__(self, v: float) -> float:
        """Value at velocity ``v``, |v| < u1."""
        return math.copysign(1 / (self.u1 - abs(v)), v) if abs(v) > self.u2 else 0.0

    def _isstatic(self) -> bool:
        return True

    def describing_function(self, A: float) -> float:
        """Equivalent gain for a sine of amplitude ``A``.

        4/(pi A) times the integral of sin p/(u1 - A sin p) over the quarter period from
        p0 = asin(u2/A) on, where the term acts.
        """
        if self.u2 >= A:
            return 0.0
        if self.u1 <= A:
            return math.inf
        begin = math.asin(self.u2 / A)
        return 4 / (math.pi * A) * (self._integral(A, math.pi / 2) - self._integral(A, begin))

    def _integral(self, a: float, p: float) -> float:
        """Antiderivative of sin p/(u1 - a sin p)."""
        root = math.sqrt(self.u1**2 - a**2)
        inner = 2 / root * math.atan((self.u1 * math.tan(p / 2) - a) / root)
        return (self.u1 * inner - p) / a


class VelocityFeedback(ct.DescribingFunctionNonlinearity):
    """A law's pull on one axis against its velocity, v_c0 = 0: -V1/A times its gain, [N] or [N m].

    Its describing function falls where the barrier sets in: to a large sine of velocity the loop
    looks weak, although the barrier term alone looks ever stiffer.
    """

    def __init__(self, scenario: Scenario, law: str, axis: int) -> None:
        """``law`` on ``scenario``, ``axis`` 0 or 1."""
        super().__init__()
        self._pull = pull_of(scenario, law, axis, np.zeros(2))

    def __call__(self, v: float) -> float:
        """Pull towards v_c0 at velocity ``v``, positive for positive ``v``."""
        return -float(self._pull(float(v)))

    def _isstatic(self) -> bool:
        return True

    def describing_function(self, A: float) -> float:
        """Equivalent gain for a sine of amplitude ``A``, by the midpoint rule over a quarter."""
        p = (np.arange(800) + 0.5) * math.pi / 1600
        values = -np.asarray(self._pull(A * np.sin(p)))
        return float(2 / A * np.mean(values * np.sin(p)))
