"""The guard by itself before a robot that takes its commands late: no law, every force is asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from tests.control.guard.harness import HEAVY, LIGHT, MOST, guarded, slid
from wmr_ctrl.control.controller import guard
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.model.evaluate import evaluated
from wmr_ctrl.world.scenario import Scenario

GRIPS = (0.0, 30.0, 1e7)
"""Dry friction, N and N m."""
PIECES = 3
"""Parts of equal length between two changes of the force; all but the force differs in each."""

Chooser = Callable[[int, np.ndarray], np.ndarray]


def late(period: float, delay: float, **changed: object) -> Scenario:
    """The guarded scenario with wide bounds at a delay; ten plant steps a period."""
    return guarded(period, **{"clock.plant": period / 10, "actuator.delay": delay, **changed})


@dataclass
class Drive:
    """What happens to the robot, chosen anew in every piece; ``asked`` and ``error`` every sample.

    ``delay`` is the true one; a `Chooser` gets the sample's number and the velocity (2,).
    """

    asked: Chooser
    push: Chooser
    mass: Chooser
    friction: Chooser
    delay: float
    error: Chooser = lambda _k, v: 0.0 * v

    def speeds(self, scenario: Scenario, v: np.ndarray, samples: int) -> np.ndarray:
        """|v| (n, 2) at the end of every piece that starts when the first command acts or later."""
        system = guard(settle(scenario, None))
        step = system.function("guard", [ca.densify(system.update), ca.densify(system.y)])
        x, p, period = np.array(system.x0), system.p0, scenario.clock.control
        whole, part = divmod(round(self.delay / scenario.clock.plant), scenario.clock.substeps)
        sent, seen = [np.zeros(2)] * (whole + 1), []
        for k in range(samples):
            x, torque = evaluated(step, [*self.asked(k, v), *(v + self.error(k, v))], x, p)
            sent = [_force(torque.ravel(), scenario), *sent]
            first = part * period / scenario.clock.substeps
            for force, time in ((sent[whole + 1], first), (sent[whole], period - first)):
                v = self._moved(k, v, force, time, seen)
            sent = sent[: whole + 1]
        begun = whole * 2 * PIECES + (PIECES if part else 0)
        return np.abs(seen[begun:])

    def _moved(
        self, k: int, v: np.ndarray, force: np.ndarray, time: float, seen: list[Any]
    ) -> np.ndarray:
        for _ in range(PIECES if time else 0):
            push = force + self.push(k, v)
            v = slid(v, push, self.friction(k, v), self.mass(k, v), time / PIECES)
            seen.append(v)
        if not time:
            seen.extend([v] * PIECES)
        return v


def greedy(v: np.ndarray) -> np.ndarray:
    """The way in which each axis moves, forwards at rest."""
    return np.where(v < 0, -1.0, 1.0)


def hostile(draw: np.random.Generator, delay: float, nbar: np.ndarray) -> Drive:
    """Any asked force, push, mass, friction and error: by sign, by time or by chance."""

    def way() -> Chooser:
        swing, phase, kind = draw.uniform(1, 8, 2), draw.uniform(0, 2, 2), draw.integers(0, 3)
        by_time = lambda k, v: np.where((k / swing + phase) % 2 < 1, 1.0, -1.0)  # noqa: E731
        by_chance = lambda k, v: 2.0 * draw.integers(0, 2, 2) - 1  # noqa: E731
        return (lambda k, v: greedy(v), by_time, by_chance)[kind]

    asked, push, grip, light = way(), way(), way(), draw.random() < 0.6
    return Drive(
        asked=lambda k, v: 1e6 * asked(k, v),
        push=lambda k, v: MOST * push(k, v),
        mass=lambda k, v: LIGHT if light else draw.uniform(LIGHT, HEAVY),
        friction=lambda k, v: np.where(grip(k, v) > 0, GRIPS[draw.integers(3)], 0.0),
        delay=delay,
        error=lambda k, v: (
            nbar * np.array([-1.0, 1.0, draw.uniform(-1, 1)])[draw.integers(0, 3, 2)]
        ),
    )


def _force(torque: np.ndarray, scenario: Scenario) -> np.ndarray:
    r, half = scenario.robot.r, scenario.robot.l
    return np.array([torque[0] + torque[1], half * (torque[0] - torque[1])]) / r
