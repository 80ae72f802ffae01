"""The robot over a run: mass and friction of each phase, and the torque that its motion needs.

    tau_d = B1^-1 (M1 v_d' + F1(v_d)),    Eq. (4) at the desired velocity,

is inverse dynamics along the reference.  What a law asks for beyond it is its answer to the start,
to disturbances and to noise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.model.dynamics import force_to_wheel, friction, reduced_mass
from wmr_ctrl.model.evaluate import evaluated
from wmr_ctrl.symbolic import ca

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Robot, Scenario


Floats = NDArray[np.float64]

KEYS = tuple(f"robot.{name}" for name in ("m", "I", "mu", "r", "l", "g", "v_s"))
"""Numbers that the needed torque rests on, in the order of `demanded`."""
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
    """Slope of friction over v1 at rest, its largest [N s/m]."""
    _, slope = _graphs()
    return float(slope(ca.DM(_numbers(robot, phase))))


def drag(robot: Robot, phase: Phase, v: Floats | tuple[float, float]) -> Floats:
    """Friction F1 (2, N) [N, N m] of the robot in a phase at velocities ``v`` (2, N) or (2,)."""
    force, _ = _graphs()
    speeds = np.asarray(v)
    if speeds.ndim == 1:
        return evaluated(force, _numbers(robot, phase), speeds)[0]
    return np.asarray(force(ca.DM(_numbers(robot, phase)), speeds))


def _numbers(robot: Robot, phase: Phase) -> tuple[float, ...]:
    return phase.mu, phase.m, robot.g, robot.v_s


@cache
def _graphs() -> tuple[ca.Function, ca.Function]:
    """F1 at a velocity, and its slope along v1 at rest."""
    p, v = ca.SX.sym("p", 4), ca.SX.sym("v", 2)
    force = friction(p[0], p[1], p[2], p[3], v)
    slope = ca.substitute(ca.jacobian(force, v)[0, 0], v, ca.SX.zeros(2))
    return ca.Function("friction", [p, v], [ca.densify(force)]), ca.Function("slope", [p], [slope])


def demanded(robot: ca.SX, v_d: ca.SX, v_d_dot: ca.SX) -> ca.SX:
    """Torques (2,) of the right and left wheel [N m] at desired velocity and rate, (2,) each."""
    m, inertia, mu, r, half_track, g, v_s = ca.vertsplit(robot)
    force = reduced_mass(m, inertia) * v_d_dot + friction(mu, m, g, v_s, v_d)
    return force_to_wheel(r, half_track, force)


def needed_torque(scenario: Scenario, times: Floats, v_d: Floats, v_d_dot: Floats) -> Floats:
    """Torques (N, 2) of the right and left wheel [N m] at ``times`` (N,) [s].

    ``v_d`` (N, 2) [m/s, rad/s] and its rate ``v_d_dot`` (N, 2) are the reference's.
    """
    needed = np.zeros_like(v_d)
    robot = {key: scenario.value(key)[0] for key in KEYS}
    for start, changed in ((0.0, {}), *((item.t, item.values()) for item in scenario.changes)):
        robot |= {f"robot.{name}": value for name, value in changed.items()}
        rows = times >= start
        numbers = ca.DM(list(robot.values()))
        needed[rows] = np.asarray(_graph()(numbers, v_d[rows].T, v_d_dot[rows].T)).T
    return needed


@cache
def _graph() -> ca.Function:
    robot = ca.SX.sym("robot", len(KEYS))
    v_d, v_d_dot = ca.SX.sym("v_d", 2), ca.SX.sym("v_d_dot", 2)
    return ca.Function("demand", [robot, v_d, v_d_dot], [demanded(robot, v_d, v_d_dot)])
