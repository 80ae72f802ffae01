"""The first control period of a run without noise, which may already leave the limit."""

from __future__ import annotations

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import Floats, Loop
from wmr_ctrl.control.controller import controller
from wmr_ctrl.model.plant import plant, rk4_step
from wmr_ctrl.model.system import System

MOST_STEPS = 500


def first_speeds(loop: Loop) -> Floats:
    """Largest |v1| [m/s] and |omega| [rad/s] while the first torque is held, drives ideal."""
    scenario, robot = loop.scenario, plant(loop.scenario)
    inputs = np.concatenate((first_torque(loop), np.zeros(2)))
    steps = min(scenario.clock.substeps, MOST_STEPS)
    step = robot.function("step", [rk4_step(robot, ca.SX(scenario.clock.control / steps))])
    state, largest = np.array(robot.x0), np.abs(loop.start.v)
    for _ in range(steps):
        state = np.asarray(step(inputs, state, robot.p0)).ravel()
        largest = np.maximum(largest, np.abs(state[3:]))
    return largest


def first_torque(loop: Loop) -> Floats:
    """Torques (right, left) [N m] of the first sample, within the wheels' limit."""
    law = controller(loop.setup)
    first = law.function("first", [law.y])
    return np.asarray(first(_first_inputs(loop, law), law.x0, law.p0)).ravel()


def _first_inputs(loop: Loop, law: System) -> list[float]:
    start, initial = loop.start, loop.scenario.initial
    numbers = (*start.reference, *initial.pose, *initial.velocity)
    sizes = sum(port.signal.size for port in law.inputs)
    return [*numbers, *(0.0 for _ in range(sizes - len(numbers)))]
