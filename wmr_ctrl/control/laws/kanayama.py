"""Kinematic tracking with limited commands and computed torque (kanayama).

Source: Kanayama, Kimura, Miyazaki and Noguchi, A stable tracking control method for an autonomous
mobile robot (ICRA 1990), above a velocity loop (`velocity_loop`):

    wanted   = (v1_d cos e3 + kx e1,  v2_d + v1_d (ky e2 + kt sin e3))

Differences from the paper: not in it, and not Eq. (7), whose angular gain does not fade with v1_d.
No barrier and no theorem: it limits the command to a margin below the limit, and a robot that
overshoots the command may use up the margin.  Choose it as a plain and good law to compare with, or
behind the guard.
"""

from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.world.model.system import System

from .context import LawContext
from .law import Basis, Inside, Law, Traits
from .velocity_loop import CHANGE, VelocityLoopGains, loop_rule, with_command, with_torque

TITLE = "kinematic tracking with limited commands (kanayama)"


class KanayamaGains(VelocityLoopGains, key="gains.kanayama"):
    """Gains of the kinematic law, and of the velocity loop below it."""

    k: tuple[float, float, float] = quantity(
        (4.0, 64.0, 16.0), "1/s, 1/m2, 1/m", "kx, ky, kt of the kinematic law", above=0.0
    )


def build(context: LawContext) -> System:
    """F of the velocity loop, for the wanted velocity above."""
    return with_torque(context, TITLE, wanted_velocity)


def inside(context: LawContext) -> Inside:
    """The law without any limit on its command."""
    within: dict[str, tuple[ca.SX, ca.SX]] = {}

    def whole(name: str, values: ca.SX, most: ca.SX) -> ca.SX:
        within[name] = values, most
        return values

    build = with_command if context.scenario.takes_velocity else with_torque
    law = build(context, TITLE, wanted_velocity, whole)
    return Inside(law, within, from_measured=frozenset({CHANGE}))


def build_command(context: LawContext) -> System:
    """Velocity for a base that follows it by its own loop."""
    return with_command(context, TITLE, wanted_velocity)


def wanted_velocity(context: LawContext) -> ca.SX:
    """Kanayama's velocity (2,) [m/s, rad/s], before any limit."""
    kx, ky, kt = ca.vertsplit(context.gain("k"))
    (e1, e2, e3), (v1_d, v2_d) = ca.vertsplit(context.e), ca.vertsplit(context.v_d)
    return ca.vertcat(v1_d * ca.cos(e3) + kx * e1, v2_d + v1_d * (ky * e2 + kt * ca.sin(e3)))


def rule(basis: Basis) -> Mapping[str, object]:
    """Gains derived from the base and its path."""
    kx, ky, turning = basis.k
    return {"k": (kx, ky, turning / basis.speed), **loop_rule(basis)}


TRAITS = Traits(model=True, observer=True)
TUNED = ("k", "rate", "wo", "a_max")
LAW = Law(
    "kanayama", KanayamaGains, build, TRAITS, __doc__, TUNED, build_command, inside, rule=rule
)
