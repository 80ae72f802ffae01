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
        kept = loop.guarded and actuator.lag == 0
        promise = "The guard keeps the limits all the same, not the path. " if kept else ""
        yield Warning(
            "actuator.delay",
            f"actuator.delay = {actuator.delay:g} s is a whole control period or more; the "
            "theorems let the torque act at once, and at 10 ms a single period of delay is enough "
            f"to break mb. {promise}Lower the gains, or shorten both clock.control and the delay.",
            THEOREMS,
        )


def noise(loop: Loop) -> Iterator[Warning]:
    """Yield that the limit is not guaranteed under noise: on the weakest axis, or by the guard."""
    if loop.scenario.disturbance.std == 0:
        return
    if loop.guarded:
        yield from _guarded_noise(loop)
    elif loop.uses("limits."):
        yield _unguarded_noise(loop)


def _guarded_noise(loop: Loop) -> Iterator[Warning]:
    if math.isinf(loop.scenario.disturbance.truncate):
        yield Warning(
            "disturbance.truncate",
            "The torque noise is unbounded (disturbance.truncate = inf), and the guard counts on a "
            "bounded one, of 3 std unless guard.dbar says otherwise: it keeps the limit with that "
            "probability only. Set disturbance.truncate = 3 for a guarantee.",
            "guard, bound dbar",
        )


def _unguarded_noise(loop: Loop) -> Warning:
    disturbance, robot = loop.scenario.disturbance, loop.scenario.robot
    push = math.sqrt(2) * disturbance.std / robot.r * np.array((1.0, robot.l))
    pull = np.maximum(largest_pull(loop, next(phases(loop.scenario))), 0)
    axis = int(np.argmin(pull / push))
    truncate, unit = disturbance.truncate, FORCE_UNITS[axis]
    bound = "unbounded" if math.isinf(truncate) else f"cut at {truncate:g} times that"
    return Warning(
        "disturbance.std",
        f"The torque noise ({disturbance.std:g} N m rms, {bound}) is covered by no theorem: at the "
        f"start it pushes {SPEEDS[axis]} with {push[axis]:.3g} {unit} rms, and the barrier of "
        f"{loop.law} pulls back with at most {pull[axis]:.3g} {unit}. That the limit is kept is "
        "not certain: try several seeds, start nearer, or switch the guard on.",
        THEOREMS,
    )
