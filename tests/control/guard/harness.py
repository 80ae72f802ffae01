"""A robot with any mass, friction and disturbance inside stated bounds, driven by generated C."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.api import compile_law
from wmr_ctrl.world.scenario import Scenario, load_scenario, override

MOST = np.array([60.0, 15.0])
"""Bound of the disturbance in every case here [N, N m]."""
LIGHT, HEAVY = np.array([25.0, 2.7]), np.array([70.0, 7.5])
LIMITS = np.array([1.0, 1.5])
WIDE = {
    "guard.enabled": True,
    "guard.M_min": LIGHT.tolist(),
    "guard.M_max": HEAVY.tolist(),
    "guard.dbar": MOST.tolist(),
    "disturbance.std": 0.0,
}
SUBSTEPS = 20


def guarded(period: float, **changed: object) -> Scenario:
    """The nominal scenario with wide bounds, guarded, at a control period [s]."""
    values = {**WIDE, "clock.control": period, "clock.duration": 80.0, **changed}
    return override(load_scenario("paper-simulation-nominal"), values)


@dataclass
class Robot:
    """One robot: true masses, Coulomb friction [N, N m], disturbance and measurement error."""

    mass: np.ndarray
    friction: np.ndarray
    disturbance: Callable[[float, np.ndarray], np.ndarray]
    error: Callable[[], np.ndarray] = lambda: np.zeros(2)
    v: np.ndarray = None
    pose: np.ndarray = None

    def drive(self, law: str, scenario: Scenario, samples: int) -> np.ndarray:
        """Velocities (steps, 2) after every piece of every sample, the start first."""
        control = compile_law(law, scenario)
        period, reference = scenario.clock.control, scenario.reference
        seen = [self.v.copy()]
        for k in range(samples):
            control.u[:7] = _target(reference, k * period)
            control.u[7:10], control.u[10:12] = self.pose, self.v + self.error()
            self._hold(_force(control.step(), scenario), k * period, period / SUBSTEPS, seen)
        return np.array(seen)

    def _hold(self, force: np.ndarray, t: float, h: float, seen: list[np.ndarray]) -> None:
        x, y, theta = self.pose.tolist()
        for j in range(SUBSTEPS):
            v1, omega = self.v.tolist()
            push = force + self.disturbance(t + j * h, self.v)
            x, y = x - h * math.sin(theta) * v1, y + h * math.cos(theta) * v1
            theta += h * omega
            self.v = slid(self.v, push, self.friction, self.mass, h)
            seen.append(self.v)
        self.pose = np.array([x, y, theta])


def slid(
    v: np.ndarray, push: np.ndarray, friction: np.ndarray, mass: np.ndarray, h: float
) -> np.ndarray:
    """Exact velocity after ``h`` seconds of constant push against Coulomb friction."""
    each = zip(v.tolist(), push.tolist(), friction.tolist(), mass.tolist(), strict=True)
    return np.array([_slid(*one, h) for one in each])


def _slid(v: float, push: float, friction: float, mass: float, h: float) -> float:
    way = math.copysign(1.0, v or push)
    rate = (push - way * friction) / mass
    if v == 0.0:
        return h * rate if rate * way > 0 else 0.0
    stop = -v / rate if rate * way < 0 else math.inf
    if stop >= h:
        return v + h * rate
    left = push - math.copysign(friction, push)
    return (h - stop) * left / mass if abs(push) > friction else 0.0


def _force(torque: np.ndarray, scenario: Scenario) -> np.ndarray:
    r, half = scenario.robot.r, scenario.robot.l
    return np.array([torque[0] + torque[1], half * (torque[0] - torque[1])]) / r


def _target(circle: object, t: float) -> tuple[float, ...]:
    R, w = circle.radius, circle.rate
    x, y = R * np.sin(w * t), R - R * np.cos(w * t)
    return x, y, w * t - np.pi / 2, R * w, w, 0.0, 0.0
