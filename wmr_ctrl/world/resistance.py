"""Resistance of the ground: each wheel's rolling resistance, and viscous friction.

Source: Coulomb friction of each rolling wheel, which carries half the weight, smoothed as the
robot's friction; a force in proportion to the velocity for bearings and air.
"""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import BODY_FORCE, VELOCITY
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Pair, Rate, Scenario, heaviest
from .model.friction import shape
from .model.system import Number, Parameters, System, outputs, ports


class Resistance(Section, key="resistance"):
    """Coefficients; the defaults are none."""

    rolling: tuple[float, float] = quantity(
        (0.0, 0.0), "1", "force over load of the right, left wheel's rolling", minimum=0
    )
    viscous: tuple[float, float] = quantity(
        (0.0, 0.0), "N.s/m, N.m.s/rad", "force, moment over velocity", minimum=0
    )


def build(scenario: Scenario) -> System:
    """Plant-rate System: from true velocity to force on the body."""
    velocity, p = ports(VELOCITY), Parameters(scenario)
    v, omega = (item.sym for item in velocity)
    half_track, viscous = p.take("robot.l"), p.take("resistance.viscous")
    load = load_of_wheel(p.take("robot.m"), p.take("robot.g"))
    smooth = smoothed(v, half_track * omega, p.take("robot.v_s"))
    force = resisted(p.take("resistance.rolling") * load, half_track, *smooth)
    title = "rolling resistance and viscous friction"
    shown = outputs(BODY_FORCE, force - viscous * ca.vertcat(v, omega))
    return System("resistance", title, inputs=velocity, params=p.ports, outputs=shown)


def load_of_wheel(m: Number, g: Number) -> Number:
    """Half the weight [N]."""
    return m * g / 2.0


def smoothed(v: ca.SX, turn: ca.SX, v_s: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Smoothed signs of the right and the left wheel's speed; ``turn`` = l omega."""
    return shape(v + turn, v_s), shape(v - turn, v_s)


def resisted(most: ca.SX, half_track: ca.SX, right: ca.SX, left: ca.SX) -> ca.SX:
    """Force on the body (2,) [N, N m] from wheels whose largest resistance is ``most`` (2,) [N].

    ``right``, ``left``: the share of it that acts, with the sign of the wheel's speed.
    """
    forces = (most[0] * right, most[1] * left)
    return -ca.vertcat(forces[0] + forces[1], half_track * (forces[0] - forces[1]))


def bound(scenario: Scenario) -> Bound:
    """Bound due to the wheels' difference; the common part only slows the robot, like any friction.

    tanh increases and is odd, so the sum over equal wheels has the sign of v1, their difference
    that of omega.  The excess of one wheel, at most |difference| m g/2, may push the other axis,
    with lever arm l for the moment (ledger: world.resistance.*).
    """
    robot, load = scenario.robot, load_of_wheel(heaviest(scenario), scenario.robot.g)
    return Bound(dbar=pushed_by(scenario.section(Resistance).rolling, load, robot.l))


def pushed_by(
    rolling: tuple[Number, Number], load: Number, half_track: Number
) -> tuple[Number, Number]:
    """Largest thrust [N] and moment [N m] by which unequal wheels push; numbers or symbols."""
    more = abs(rolling[0] - rolling[1]) * load
    return more, half_track * more


def rolling_against(scenario: Scenario) -> Pair:
    """Largest thrust [N] and moment [N m] of rolling resistance, without the push of unequal
    wheels.
    """
    robot, load = scenario.robot, load_of_wheel(heaviest(scenario), scenario.robot.g)
    both = 2 * min(scenario.section(Resistance).rolling) * load
    return both, robot.l * both


def against(scenario: Scenario) -> Pair:
    """`rolling_against` plus viscous friction at the speed limits."""
    viscous, limits = scenario.section(Resistance).viscous, scenario.limits.v_u1
    axes = zip(rolling_against(scenario), viscous, limits, strict=True)
    linear, angular = (force + c * limit for force, c, limit in axes)
    return linear, angular


RESISTANCE = Effect("resistance", EffectRole.DISTURBANCE, Resistance, build, bound, rate=Rate.STEP)
