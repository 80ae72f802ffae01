"""The robot over a run: phases between its changes, friction, and the torque that motion needs.

    tau_d = B1^-1 (M1 v_d' + F1(v_d)),    Eq. (4) at the desired velocity,

is inverse dynamics along the reference.  The rest of a law's torque is its reaction to the start,
to disturbances and to noise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from wmr_ctrl.core.symbolic import ca

from .model.dynamics import NAMES, force_to_wheel, reduced_mass
from .model.evaluate import Floats, evaluated
from .model.friction import friction, largest_force, largest_slope
from .scenario.sections import CHANGING, robot_number

if TYPE_CHECKING:
    from .scenario import Robot, Scenario


@dataclass(frozen=True)
class Phase:
    """The robot from time ``t`` [s] on."""

    t: float
    robot: Robot


def phases(scenario: Scenario) -> Iterator[Phase]:
    """The robot at the start and from each change on."""
    robot = scenario.robot
    yield Phase(0.0, robot)
    for change in scenario.changes:
        robot = replace(robot, **change.values())
        yield Phase(change.t, robot)


def robots_in_words(scenario: Scenario) -> tuple[tuple[float, str], ...]:
    """The robot from each time [s] on as text, such as "65 kg"; empty if it never changes.

    Masses if they differ, else all numbers that change.
    """
    states = {phase.t: phase.robot for phase in phases(scenario)}
    numbers = {t: tuple(getattr(robot, name) for name in CHANGING) for t, robot in states.items()}
    if len(set(numbers.values())) < 2:
        return ()
    places = [i for i in range(len(CHANGING)) if len({own[i] for own in numbers.values()}) > 1]
    masses = {own[0] for own in numbers.values()}
    places = places[:1] if len(masses) == len(set(numbers.values())) else places
    words = {"mu": "friction "}
    names = [(i, name) for i, name in enumerate(CHANGING) if i in places]
    return tuple(
        (t, ", ".join(words.get(name, "") + robot_number(name, own[i]) for i, name in names))
        for t, own in numbers.items()
    )


def largest_friction(scenario: Scenario) -> float:
    """Largest friction of the robot over a run [N]."""
    return max(full_friction(phase.robot) for phase in phases(scenario))


def full_friction(robot: Robot) -> float:
    """Largest friction of a robot [N]."""
    return largest_force(robot.mu, robot.m, robot.g)


def steepness(robot: Robot) -> float:
    """Largest slope of a robot's friction over its speed [N s/m]."""
    return largest_slope(*_numbers(robot))


def drag(robot: Robot, v: Floats | tuple[float, float]) -> Floats:
    """Friction F1 (2, N) [N, N m] of a robot at velocities ``v`` (2, N) or (2,)."""
    force = _force()
    speeds = np.asarray(v)
    if speeds.ndim == 1:
        return evaluated(force, _numbers(robot), speeds)[0]
    return np.asarray(force(ca.DM(_numbers(robot)), speeds))


def _numbers(robot: Robot) -> tuple[float, float, float, float]:
    return robot.mu, robot.m, robot.g, robot.v_s


@cache
def _force() -> ca.Function:
    """F1 at a velocity."""
    p, v = ca.SX.sym("p", 4), ca.SX.sym("v", 2)
    return ca.Function("friction", [p, v], [ca.densify(friction(p[0], p[1], p[2], p[3], v))])


def demanded(robot: ca.SX, v_d: ca.SX, v_d_dot: ca.SX) -> ca.SX:
    """Torques (2,) of the right and left wheel [N m] at desired velocity and rate, (2,) each.

    ``robot``: its numbers in the order of `NAMES`.
    """
    m, inertia, mu, r, half_track, g, v_s = ca.vertsplit(robot)
    force = reduced_mass(m, inertia) * v_d_dot + friction(mu, m, g, v_s, v_d)
    return force_to_wheel(r, half_track, force)


def needed_torque(scenario: Scenario, times: Floats, v_d: Floats, v_d_dot: Floats) -> Floats:
    """Torques (N, 2) of the right and left wheel [N m] at ``times`` (N,) [s].

    ``v_d`` (N, 2) [m/s, rad/s] and its rate ``v_d_dot`` (N, 2) are the reference's.
    """
    needed = np.zeros_like(v_d)
    for phase in phases(scenario):
        rows = times >= phase.t
        numbers = ca.DM([vars(phase.robot)[name] for name in NAMES])
        needed[rows] = np.asarray(_graph()(numbers, v_d[rows].T, v_d_dot[rows].T)).T
    return needed


@cache
def _graph() -> ca.Function:
    robot = ca.SX.sym("robot", len(NAMES))
    v_d, v_d_dot = ca.SX.sym("v_d", 2), ca.SX.sym("v_d_dot", 2)
    return ca.Function("demand", [robot, v_d, v_d_dot], [demanded(robot, v_d, v_d_dot)])
