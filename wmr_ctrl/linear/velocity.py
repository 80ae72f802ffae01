"""The velocity loop of one axis alone: what a law's force does for an auxiliary velocity that stays."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wmr_ctrl.checks.barrier import Phase, drag
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.scenario import Scenario


def pull_of(
    scenario: Scenario, law: str, axis: int, v_c0: Floats
) -> Callable[[float | Floats], Floats]:
    """Force [N] or moment [N m] of ``axis`` (0, 1) at its velocity, friction compensation aside.

    ``v_c0`` (2) stays; the other axis rests at its own v_c0.  What is taken off is the friction that
    the law believes in, so that a correct model leaves the barrier's own pull.
    """
    loop = Loop(scenario, law)
    compensated = 1.0 if loop.uses("model.mu") else 0.0
    robot = scenario.believed
    phase = Phase(0.0, robot.m, robot.mu)

    def pull(v: float | Floats) -> Floats:
        speeds = np.tile(np.asarray(v_c0, float)[:, None], (1, np.size(v)))
        speeds[axis] = v
        own = loop.force_towards(speeds, v_c0)[axis]
        own = own - compensated * drag(robot, phase, speeds)[axis]
        return own if np.ndim(v) else own[0]

    return pull
