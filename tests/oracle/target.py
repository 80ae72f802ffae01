"""The desired state at one instant, and how it follows from the derivatives of a path."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wmr_ctrl.core.signals import REFERENCE

_NAMES = [signal.name for signal in REFERENCE]


@dataclass(frozen=True, slots=True)
class DesiredState:
    """Desired state in the order of ``signals.REFERENCE`` [m, m, rad, m/s, rad/s, m/s2, rad/s2]."""

    x: float
    y: float
    theta: float
    v1: float
    v2: float
    v1_dot: float
    v2_dot: float

    def columns(self):
        """The values by the names of their signals."""
        return dict(zip(_NAMES, map(self.__getattribute__, self.__slots__), strict=True))


def target_on(place, theta, rate, rate2, rate3):
    """Target on a path that is driven forwards, from its first three derivatives by time.

    ``theta`` is the orientation of ``rate``; v2 is the rate at which that direction turns.
    """
    (x1, y1), (x2, y2), (x3, y3) = rate, rate2, rate3
    v1 = math.hypot(x1, y1)
    v1_dot = (x1 * x2 + y1 * y2) / v1
    v2 = (x1 * y2 - y1 * x2) / (v1 * v1)
    v2_dot = (x1 * y3 - y1 * x3) / (v1 * v1) - 2.0 * v2 * v1_dot / v1
    return DesiredState(place[0], place[1], theta, v1, v2, v1_dot, v2_dot)
