"""Describing functions of the barrier: what a sine of velocity meets, as an equivalent gain.

`control.describing_function`, `control.describing_function_response` and their plots take these.
"""

from __future__ import annotations

import math
from typing import Any

import control as ct
import numpy as np

from wmr_ctrl.linear.velocity import pull_of
from wmr_ctrl.scenario import Scenario


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
        values: Any = -np.asarray(self._pull(A * np.sin(p)))
        return float(2 / A * np.mean(values * np.sin(p)))
