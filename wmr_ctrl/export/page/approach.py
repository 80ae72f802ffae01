"""The rule of a collision monitor that approaches obstacles, behind a law, for the page alone.

Transcribed in our words from the documentation of nav2's collision monitor, action "approach": a
command is scaled so that a drive at that command would not meet an obstacle within `HORIZON`. It
knows neither delay, lag nor pushes. Here it sees the obstacles exactly and looks straight ahead;
nav2's node was not run.
"""

from dataclasses import replace
from functools import lru_cache

import casadi as ca

from wmr_ctrl.control.laws.context import LawContext
from wmr_ctrl.control.laws.law import Law
from wmr_ctrl.core.signals import ASKED
from wmr_ctrl.world.model.system import Output, System
from wmr_ctrl.world.sight import free_distances

HORIZON = 1.2
"""Time [s] that stays before a collision, as nav2 ships it."""
SLOWEST = 1e-9
"""Speed [m/s] below which a command is not scaled."""


@lru_cache
def approaching(law: Law) -> Law:
    """The ``law``, which must have a form for bases that take velocities, behind the rule."""

    def command(context: LawContext) -> System:
        radius = context.parameters.take("body.radius")
        assert law.command is not None, f"{law.name} does not command velocities"
        own = law.command(context)
        asked = own.outputs[0].expr
        straight = ca.SX(0), ca.SX(0)
        ahead, behind = free_distances(context.scenario.obstacles, context.pose, straight, radius)
        way = ca.fmax(0, ca.if_else(asked[0] < 0, behind, ahead))
        share = ca.fmin(1, way / (HORIZON * ca.fmax(ca.fabs(asked[0]), SLOWEST)))
        return replace(own, outputs=(Output(ASKED, share * asked),))

    return replace(law, command=command)
