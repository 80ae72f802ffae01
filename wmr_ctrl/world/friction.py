"""The robot's friction over a run, in numbers from the graph of Eq. (4)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.model.dynamics import friction
from wmr_ctrl.symbolic import ca

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Robot, Scenario

Floats = NDArray[np.float64]

FAST = 1e6
"""Speed [m/s] at which nothing is missing of friction's full size."""


@dataclass(frozen=True)
class Phase:
    """The robot's friction from time ``t`` [s] on."""

    t: float
    m: float
    mu: float


def phases(scenario: Scenario) -> Iterator[Phase]:
    """Yield the robot's friction at the start and from each change on."""
    phase = Phase(0.0, scenario.robot.m, scenario.robot.mu)
    yield phase
    for change in scenario.changes:
        mass = phase.m if change.m is None else change.m
        phase = Phase(change.t, mass, phase.mu if change.mu is None else change.mu)
        yield phase


def largest_friction(scenario: Scenario) -> float:
    """Largest friction of the robot over a run [N]."""
    return max(full_friction(scenario.robot, phase) for phase in phases(scenario))


def full_friction(robot: Robot, phase: Phase) -> float:
    """Friction of a robot that moves [N]: mu m g."""
    return float(drag(robot, phase, (FAST, 0.0))[0, 0])


def steepness(robot: Robot, phase: Phase) -> float:
    """By how much friction rises with v1 at rest, where it does so most [N s/m]."""
    _, slope = _graphs()
    return float(slope(ca.DM(_numbers(robot, phase))))


def drag(robot: Robot, phase: Phase, v: Floats | tuple[float, float]) -> Floats:
    """Friction F1 (2, N) [N, N m] of the robot in a phase at velocities ``v`` (2, N) or (2,)."""
    force, _ = _graphs()
    return np.asarray(force(ca.DM(_numbers(robot, phase)), np.asarray(v)))


def _numbers(robot: Robot, phase: Phase) -> tuple[float, ...]:
    return phase.mu, phase.m, robot.g, robot.v_s


@cache
def _graphs() -> tuple[ca.Function, ca.Function]:
    """F1 at a velocity, and its slope along v1 at rest."""
    p, v = ca.SX.sym("p", 4), ca.SX.sym("v", 2)
    force = friction(p[0], p[1], p[2], p[3], v)
    slope = ca.substitute(ca.jacobian(force, v)[0, 0], v, ca.SX.zeros(2))
    return ca.Function("friction", [p, v], [force]), ca.Function("slope", [p], [slope])
