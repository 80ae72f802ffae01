"""Limits of both directions as graphs read them.

Where a scenario limits no direction apart, both are v_u1.
"""

import casadi as ca

from wmr_ctrl.world.model.system import Parameters
from wmr_ctrl.world.scenario.sections import Limits


def sides(limits: Limits, p: Parameters, kept: float = 0.0) -> tuple[ca.SX, ca.SX]:
    """Limits of the velocities (2,) and of their negatives, less a share that is ``kept`` back.

    It is one of the larger limit, since numbers as large as that are rounded.
    """
    if not limits.apart:
        both = p.take("limits.v_u1") * (1 - kept)
        return both, both
    ahead, back = p.take("limits.v_max"), -p.take("limits.v_min")
    less = kept * ca.fmax(ahead, back)
    return ahead - less, back - less
