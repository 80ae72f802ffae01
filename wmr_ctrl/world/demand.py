"""Wheel torques that the desired motion itself needs: inverse dynamics along the reference.

    tau_d = B1^-1 (M1 v_d' + F1(v_d)),    Eq. (4) at the desired velocity,

with the robot's mass, inertia and friction of each phase.  What a law asks for beyond it is its
answer to the start, to disturbances and to noise.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.model.dynamics import force_to_wheel, friction, reduced_mass
from wmr_ctrl.symbolic import ca

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Scenario

Floats = NDArray[np.float64]

KEYS = tuple(f"robot.{name}" for name in ("m", "I", "mu", "r", "l", "g", "v_s"))
"""Numbers that the torque rests on, in the order of `demanded`."""


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
    robot, v_d, v_d_dot = (
        ca.SX.sym("robot", len(KEYS)),
        ca.SX.sym("v_d", 2),
        ca.SX.sym("v_d_dot", 2),
    )
    return ca.Function("demand", [robot, v_d, v_d_dot], [demanded(robot, v_d, v_d_dot)])
