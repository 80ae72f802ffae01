"""Limits of both directions as graphs read them, including limits that change during a run.

If a scenario states no separate limits for the directions, both are v_u1.
"""

import casadi as ca

from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.model.system import Parameters, Port, port
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.scenario.sections import Limits


def sides(limits: Limits, p: Parameters, kept: float = 0.0) -> tuple[ca.SX, ca.SX]:
    """Limits of the velocities (2,) and of their negatives, less a share ``kept`` for rounding.

    The share is one of the larger limit, since numbers of that size are rounded.
    """
    if not limits.apart:
        both = p.take("limits.v_u1") * (1 - kept)
        return both, both
    ahead, back = p.take("limits.v_max"), -p.take("limits.v_min")
    less = kept * ca.fmax(ahead, back)
    return ahead - less, back - less


LIMITS = Signal(
    "limits", "m/s, m/s, rad/s, rad/s", "limits in force: v_min, v_max, omega_min, omega_max", 4
)


def limits_port(scenario: Scenario) -> Port:
    """Input of limits that change; its default is the scenario's limits."""
    return port(LIMITS, [end for side in scenario.limits.sides for end in side])


def is_number(value: ca.SX) -> ca.SX:
    """1 for every number, infinity too; 0 for NaN."""
    return ca.logic_or(value >= 0, value < 0)
