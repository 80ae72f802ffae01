"""Sampled-data barrier law, from its definition."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.oracle.law import Pair, Sight
from wmr_ctrl.sim.oracle.observer import ForceObserver


class Prox:
    """F = M1 (v+ - v)/T + F1(v) + f, v+ the implicit step of V1's gradient flow."""

    def __init__(self, gains: Mapping[str, Any], scenario: Scenario) -> None:
        self.gains, self.limits = gains, scenario.limits
        self.T, self.bot = scenario.clock.control, scenario.believed
        self.smooth = gains["barrier"] == "smooth"
        self.observer = ForceObserver(gains["wo"], scenario)

    def act(self, sight: Sight) -> Pair:
        """Generalised force (thrust [N], moment [N m]); the observer moves before it."""
        force, moment = self.observer.look(sight)
        drag = self.observer.friction(sight.v[0])
        return (
            self.bot.m * self._acceleration(0, sight) + drag + force,
            self.bot.I * self._acceleration(1, sight) + moment,
        )

    def _acceleration(self, i: int, sight: Sight) -> float:
        v, c = sight.v[i], sight.v_c0[i]
        c_next = c + self.T * sight.v_c0_dot[i]
        half = self.gains["rho"][i] * self.T / 2.0
        keep, rest = math.exp(-half), -math.expm1(-half)
        start = v + self._near(i, c_next, 1.0) - self._near(i, c, 1.0)
        return (self._near(i, keep * start + rest * c_next, rest) - v) / self.T

    def _near(self, i: int, c: float, k: float) -> float:
        return nearest(c, k, self.limits.v_u1[i], self.limits.v_u2[i], self.smooth)

    def memory(self) -> dict[str, Pair]:
        """The disturbance that the observer makes up for."""
        return self.observer.memory()


def nearest(c: float, k: float, u1: float, u2: float, smooth: bool = False) -> float:
    """The x that minimises (x - c)^2/2 + k f(x), |x| < u1 [m/s or rad/s]."""
    return math.copysign(_right(abs(c), k, u1, u2, smooth), c)


def _right(c: float, k: float, u1: float, u2: float, smooth: bool) -> float:
    if c <= u2:
        return c
    delta = u1 - u2
    if smooth:
        d = _root(c - u1 + k / delta, k)
        return u2 + (c - u2) / (1.0 + k / (d * delta))
    if c <= u2 + k / delta:
        return u2
    return u1 - _root(c - u1, k)


def _root(t: float, k: float) -> float:
    """d > 0 with d (d + t) = k."""
    r = math.hypot(t, 2.0 * math.sqrt(k))
    return 2.0 * k / (t + r) if t >= 0.0 else (r - t) / 2.0
