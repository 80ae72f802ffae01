"""Slope: an inclined plane; it pulls along the heading, and turns a robot with offset mass.

Source: gravity on an incline. The wheels resist the lateral pull, which has a lever arm if the
centre of mass is ``offset`` ahead of the axle. The wheels' load, and so the friction, stays that of
level ground.
"""

from __future__ import annotations

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import BODY_FORCE, POSE
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario, heaviest
from .model.system import Number, Parameters, System, outputs, port


class Slope(Section, key="slope"):
    """Rise of the ground, its direction, and the robot's centre of mass."""

    angle: float = quantity(
        0.0, "rad", "rise of the ground where it is steepest", minimum=0, maximum=1.0
    )
    direction: float = quantity(0.0, "rad", "heading psi of the steepest rise")
    offset: float = quantity(
        0.0, "m", "how far ahead of the axle the slope finds the centre of mass"
    )


def build(scenario: Scenario) -> System:
    """Plant-rate System: from orientation to force on the body.

    With a = psi - direction: thrust -m g sin(angle) cos(a), moment offset m g sin(angle) sin(a).
    """
    theta, p = port(POSE[2]), Parameters(scenario)
    pull = downhill(p.take("robot.m"), p.take("robot.g"), ca.sin(p.take("slope.angle")))
    a = turned(theta.sym, p.take("slope.direction"))
    force = pulled(pull, p.take("slope.offset"), ca.cos(a), ca.sin(a))
    shown = outputs(BODY_FORCE, force)
    return System("slope", "slope of the ground", inputs=(theta,), params=p.ports, outputs=shown)


def turned(theta: ca.SX, direction: ca.SX) -> ca.SX:
    """Angle of the heading psi from the steepest rise [rad]."""
    return theta + ca.pi / 2 - direction


def downhill(m: Number, g: Number, sine: Number) -> Number:
    """Pull of a slope [N]."""
    return m * g * sine


def pulled(pull: ca.SX, offset: ca.SX, along: ca.SX, across: ca.SX) -> ca.SX:
    """Force on the body (2,) [N, N m] of a pull downhill [N] by the shares along and across."""
    return ca.vertcat(-pull * along, offset * pull * across)


def bound(scenario: Scenario) -> Bound:
    """Largest pull on the heaviest assumed robot, straight downhill and across (ledger:
    world.slope.*).
    """
    slope = scenario.section(Slope)
    pull = downhill(heaviest(scenario), scenario.robot.g, math.sin(slope.angle))
    return Bound(dbar=pulled_at_most(pull, slope.offset))


def pulled_at_most(pull: Number, offset: Number) -> tuple[Number, Number]:
    """Largest thrust [N] and moment [N m] of a pull [N], for numbers or symbols."""
    return pull, pull * abs(offset)


SLOPE = Effect(
    "slope", EffectRole.DISTURBANCE, Slope, build, bound, switches=("angle",), rate=Rate.STEP
)
