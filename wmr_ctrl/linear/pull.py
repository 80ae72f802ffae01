"""Pull of a barrier on one axis: from nothing at v_c1 over a peak to nothing at the limit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wmr_ctrl.linear.linearise import Floats
from wmr_ctrl.linear.point import law_loop
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.world.phases import Phase, drag


def pull_of(
    scenario: Scenario, law: str, axis: int, v_c0: Floats, period: float | None = None
) -> Callable[[float | Floats], Floats]:
    """Force [N] or moment [N m] of ``axis`` (0, 1) at its velocity, friction compensation aside.

    ``v_c0`` (2) stays; the other axis rests at its own v_c0.  The friction that the law believes
    in is taken off, so that with a correct model the barrier's own pull is left.  The law runs at
    ``period`` [s], by default the scenario's.
    """
    loop = law_loop(scenario, law)
    compensated = 1.0 if loop.uses("model.mu") else 0.0
    robot = scenario.believed
    phase = Phase(0.0, robot.m, robot.mu)

    def pull(v: float | Floats) -> Floats:
        speeds = np.tile(np.asarray(v_c0, float)[:, None], (1, np.size(v)))
        speeds[axis] = v
        own = loop.force_towards(speeds, v_c0, period)[axis]
        own = own - compensated * drag(robot, phase, speeds)[axis]
        return own if np.ndim(v) else own[0]

    return pull


def pull_curve(scenario: Scenario, law: str, axis: int, v_c0: float, speeds: Floats) -> Floats:
    """Force [N] or moment [N m] of the law over ``speeds`` (N,), its friction term taken off."""
    asked = np.zeros(2)
    asked[axis] = v_c0
    return np.asarray(pull_of(scenario, law, axis, asked)(speeds))
