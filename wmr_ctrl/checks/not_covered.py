"""What the theorems leave out although the scenario has it: drives that are not ideal, noise."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from wmr_ctrl.checks.barrier import largest_pull, phases
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.checks.wording import FORCE_UNITS, SPEEDS

THEOREMS = "Theorems 1 and 2"


def drives(loop: Loop) -> Iterator[Warning]:
    """Yield a torque limit that friction uses up, and a delay of one sample or more."""
    scenario, actuator = loop.scenario, loop.scenario.actuator
    thrust = 2 * actuator.tau_max / scenario.robot.r
    friction = max(phase.m * phase.mu * scenario.robot.g for phase in phases(scenario))
    if friction >= thrust:
        yield Warning(
            "actuator.tau_max",
            f"actuator.tau_max = {actuator.tau_max:g} N m gives {thrust:.3g} N of thrust at most, "
            f"and friction takes {friction:.3g} N: the robot cannot keep moving. Raise it above "
            f"{friction * scenario.robot.r / 2:.3g} N m.",
            "Eq. (4)",
        )
    if actuator.delay >= scenario.clock.control:
        yield Warning(
            "actuator.delay",
            f"actuator.delay = {actuator.delay:g} s is a whole control period or more; the "
            "theorems let the torque act at once, and at 10 ms a single period of delay is enough "
            "to break mb. Lower the gains, or shorten both clock.control and the delay.",
            THEOREMS,
        )


def noise(loop: Loop) -> Iterator[Warning]:
    """Yield that a barrier law's limit is not guaranteed under noise, on the weakest axis."""
    disturbance, robot = loop.scenario.disturbance, loop.scenario.robot
    if disturbance.std == 0 or not loop.uses("limits."):
        return
    push = math.sqrt(2) * disturbance.std / robot.r * np.array((1.0, robot.l))
    pull = np.maximum(largest_pull(loop, next(phases(loop.scenario))), 0)
    axis = int(np.argmin(pull / push))
    truncate, unit = disturbance.truncate, FORCE_UNITS[axis]
    bound = "unbounded" if math.isinf(truncate) else f"cut at {truncate:g} times that"
    yield Warning(
        "disturbance.std",
        f"The torque noise ({disturbance.std:g} N m rms, {bound}) is covered by no theorem: at the "
        f"start it pushes {SPEEDS[axis]} with {push[axis]:.3g} {unit} rms, and the barrier of "
        f"{loop.law} pulls back with at most {pull[axis]:.3g} {unit}. That the limit is kept is "
        "not certain: try several seeds, or start nearer.",
        THEOREMS,
    )
