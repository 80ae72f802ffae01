"""Regulated pure pursuit: an arc to a point ahead of the reference, slower in tight turns.

Source: Macenski, Singh, Martin and Gines, Regulated pure pursuit for robot path tracking (2023),
above a velocity loop (`velocity_loop`).  With c = (ahead, left) [m] the point at the distance L
along the reference's present arc, relative to the robot,

    L        = cut(lookahead v1_d, distance),      kappa = 2 c_left/|c|^2
    pace     = max(v1_d + k e1, 0)
    v        = min(pace, max(pace min(1, 1/(|kappa| radius)), slowest))
    wanted   = eta (v, kappa v),   eta <= 1: both within share v_u1, on the same arc
    wanted   = (0, +-turn)   if the direction of c is more than turn_from off the heading

Differences from the paper: not in it.  Differences from the source: the point runs ahead of the
reference, which is a function of time, and not of the nearest point of a path; k e1 keeps pace with
that time (k = 0: it does not).  Its obstacle and goal heuristics are absent, since a scenario has
no cost map.  It only drives forwards.  No barrier and no theorem.  Choose it to compare with what
most robots with ROS run.
"""

from collections.abc import Mapping

import casadi as ca

from wmr_ctrl.core.fields.section import quantity
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario.sections import check_intervals

from . import velocity_loop
from .context import LawContext
from .law import Basis, Law, Traits

TITLE = "regulated pure pursuit"
TINY = 1e-6
"""Speed of the reference [m/s] below which its arc straightens, since it has none."""
WIDEST = 1.5
"""Angle [rad] of the reference's arc up to the point: no farther round."""


class PursuitGains(velocity_loop.VelocityLoopGains, key="gains.pursuit"):
    """Lengths and speeds of the pursuit, and gains of the velocity loop below it."""

    lookahead: float = quantity(1.5, "s", "lookahead time along the reference", above=0.0)
    distance: tuple[float, float] = quantity(
        (0.3, 0.9), "m", "bounds of the lookahead distance", above=0.0
    )
    k: float = quantity(
        1.0, "1/s", "gain on the distance from the reference along the path", minimum=0.0
    )
    radius: float = quantity(
        0.9, "m", "radius of an arc below which it drives slower, 0: never", minimum=0.0
    )
    slowest: float = quantity(0.25, "m/s", "lowest speed to which an arc reduces it", minimum=0.0)
    turn: float = quantity(1.8, "rad/s", "speed of turning on the spot", above=0.0)
    turn_from: float = quantity(
        0.785, "rad", "angle to the lookahead point above which it turns on the spot", above=0.0,
        maximum=3.15,
    )  # fmt: skip

    def relate(self) -> None:
        """Check that the bounds of the distance ahead are in order."""
        check_intervals(self, {"distance": "the way ahead"})


def build(context: LawContext) -> System:
    """F of the velocity loop, for the wanted velocity above."""
    return velocity_loop.with_torque(context, TITLE, wanted_velocity)


def build_command(context: LawContext) -> System:
    """Velocity for a base that follows it by its own loop."""
    return velocity_loop.with_command(context, TITLE, wanted_velocity)


def wanted_velocity(context: LawContext) -> ca.SX:
    """The pursuit's velocity (2,) [m/s, rad/s], within the share of the limits."""
    top = velocity_loop.largest_command(context)
    point, way = point_ahead(context)
    square = ca.dot(point, point)
    kappa = 2 * point[1] / ca.fmax(square, way**2 / 4)
    pace = ca.fmax(context.v_d[0] + context.gain("k") * context.e[0], 0)
    tight = ca.fabs(kappa) * context.gain("radius")
    v = ca.fmin(pace, ca.fmax(pace / ca.fmax(tight, 1), context.gain("slowest")))
    arc = ca.vertcat(v, kappa * v)
    share = ca.fmax(1, ca.fmax(v / top[0], ca.fabs(arc[1]) / top[1]))
    turn = ca.fmin(context.gain("turn"), top[1])
    aside = point[0] < ca.cos(context.gain("turn_from")) * ca.sqrt(square)
    spot = ca.vertcat(0, ca.if_else(point[1] >= 0, turn, -turn))
    return ca.if_else(aside, spot, arc / share)


def point_ahead(context: LawContext) -> tuple[ca.SX, ca.SX]:
    """The point (ahead, left) [m] relative to the robot, and its distance along the arc [m]."""
    nearest, farthest = ca.vertsplit(context.gain("distance"))
    v1_d, v2_d = ca.vertsplit(context.v_d)
    way = ca.fmin(ca.fmax(context.gain("lookahead") * v1_d, nearest), farthest)
    bent = way * v2_d * v1_d / ca.fmax(v1_d**2, TINY**2)
    half = ca.fmax(-WIDEST, ca.fmin(WIDEST, bent)) / 2
    chord = way * ca.if_else(half == 0, 1, ca.sin(half) / ca.if_else(half == 0, 1, half))
    e1, e2, e3 = ca.vertsplit(context.e)
    towards = e3 + half
    return ca.vertcat(e1 + chord * ca.cos(towards), e2 + chord * ca.sin(towards)), way


def rule(basis: Basis) -> Mapping[str, object]:
    """Gains derived from the base and its limits."""
    v, omega = basis.limits
    return {
        "lookahead": max(1.5, 6 / basis.wo),
        "k": min(1.0, basis.k[0]),
        "distance": (0.6 * v, 1.8 * v),
        "radius": 1.8 * v,
        "slowest": 0.5 * v,
        "turn": 0.8 * omega,
        **velocity_loop.loop_rule(basis),
    }


TRAITS = Traits(model=True, observer=True)
TUNED = ("lookahead", "k", "rate", "wo", "a_max")
LAW = Law("pursuit", PursuitGains, build, TRAITS, __doc__, TUNED, build_command, rule=rule)
