"""The velocity loop of one axis alone: a law's force while the auxiliary velocity stays."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wmr_ctrl.checks.barrier import Phase, drag
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.scenario import Scenario


def dead_zone(scenario: Scenario) -> Floats:
    """|v_c0| from v_u2 to v_u2 + 1/(v_u1 - v_u2), per axis (2, 2): v_c1 = v_u2 there."""
    u1, u2 = np.array(scenario.limits.v_u1), np.array(scenario.limits.v_u2)
    return np.stack((u2, u2 + 1 / (u1 - u2)), axis=1)


def pull_of(
    scenario: Scenario, law: str, axis: int, v_c0: Floats
) -> Callable[[float | Floats], Floats]:
    """Force [N] or moment [N m] of ``axis`` (0, 1) at its velocity, friction compensation aside.

    ``v_c0`` (2) stays; the other axis rests at its own v_c0.  The friction that the law believes
    in is taken off, so that with a correct model the barrier's own pull is left.
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
