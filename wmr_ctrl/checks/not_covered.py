"""What the theorems leave out although the scenario has it: drives that are not ideal, noise."""

from __future__ import annotations

import math
from collections.abc import Iterator

from wmr_ctrl.checks.barrier import phases
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.warning import Warning

THEOREMS = "Theorems 1 and 2"


def drives(loop: Loop) -> Iterator[Warning]:
    """Yield a torque limit that friction uses up, and a delay of one sample or more."""
    scenario, actuator = loop.scenario, loop.scenario.actuator
    thrust = 2 * actuator.tau_max / scenario.robot.r
    largest = max(phase.m * phase.mu * scenario.robot.g for phase in phases(scenario.robot, scenario.changes))
    if largest >= thrust:
        yield Warning(
            "actuator.tau_max",
            f"actuator.tau_max = {actuator.tau_max:g} N m gives at most {thrust:.3g} N of thrust, and "
            f"friction takes {largest:.3g} N: the robot cannot keep moving. Raise it above "
            f"{largest * scenario.robot.r / 2:.3g} N m.",
            "Eq. (4)",
        )
    if actuator.delay >= scenario.clock.control:
        yield Warning(
            "actuator.delay",
            f"actuator.delay = {actuator.delay:g} s is a whole control period or more; the theorems "
            "let the torque act at once, and at 10 ms a single period of delay is enough to break mb. "
            "Lower the gains, or shorten both clock.control and the delay.",
            THEOREMS,
        )


def noise(loop: Loop) -> Iterator[Warning]:
    """Yield that a barrier law's limit is not guaranteed under noise."""
    disturbance = loop.scenario.disturbance
    if disturbance.std == 0 or not loop.uses("limits."):
        return
    bound = (
        "and it has no bound (disturbance.truncate = inf)"
        if math.isinf(disturbance.truncate)
        else f"cut off at {disturbance.truncate * disturbance.std:g} N m"
    )
    yield Warning(
        "disturbance.std",
        f"The torque noise, {disturbance.std:g} N m rms {bound}, is in no theorem: that {loop.law} "
        "keeps the limit is likely, not certain. Several seeds show how likely.",
        THEOREMS,
    )
