"""Traction limits: torques at which wheels spin or lift, in closed form.

The robot of [robot] and [body] on level ground, in the quasi-static mechanics of a rigid body with
its centre of mass over the axle.  With N_c of the weight on one caster and a thrust F = m a,

    2 (tau - drag) = a r (m + m_w),    N_c caster = a (m height + m_w r),    F <= tyre (m g - N_c),

m_w the mass of one wheel, a disc, and drag = mu m g r/2 that of one bearing.  The wheels spin
beyond a = tyre g/(1 + tyre (height + m_w r/m)/caster), before the caster has all the weight.
Wheels that spin gain little thrust, and their torque turns the chassis about its caster: it lifts
the wheels where 2 (tau - drag) exceeds m g caster.

Source: none in the paper, whose robot does neither; tests hold both against MuJoCo.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .phases import phases

if TYPE_CHECKING:
    from .scenario import Robot, Scenario


@dataclass(frozen=True)
class Grip:
    """Wheel torques [N m] of the scenario's robot at its start.

    ``spin``: torque at which forward-driving wheels begin to slide; ``brake``: at which braking
    wheels do, helped by drag; ``keep``: below which no wheel slides for any motion within
    limits.v_u1, driving, braking or turning; ``lift``: at which spinning wheels lift off.
    """

    spin: float
    brake: float
    keep: float
    lift: float


def grip(scenario: Scenario) -> Grip:
    """Torques of a scenario's robot; ``keep`` is the minimum over its phases, 0 if a phase has
    none.

    The other torques are for the robot at the start.
    """
    forces = [_forces(scenario, phase.robot) for phase in phases(scenario)]
    first = forces[0]
    return Grip(first.spin, first.brake, max(0.0, min(item.keep for item in forces)), first.lift)


def _forces(scenario: Scenario, robot: Robot) -> Grip:
    body, m, r = scenario.body, robot.m, robot.r
    tyre, wheel = body.tyre, body.wheel_mass
    bearing, lever = robot.mu * m * robot.g * r / 2, (body.height + wheel * r / m) / body.caster
    most = tyre * robot.g / (1 + tyre * lever)
    rolling = r * (m + wheel) * most / 2
    return Grip(
        rolling + bearing,
        rolling - bearing,
        _in_a_turn(scenario, robot, most) - bearing,
        m * robot.g * body.caster / 2 + bearing,
    )


def _in_a_turn(scenario: Scenario, robot: Robot, most: float) -> float:
    """Torque [N m] that the lighter wheel can transmit in the tightest turn at v_u1.

    For a longitudinal acceleration ``most`` [m/s2]; the tyres share the lateral force as their
    load.
    """
    m, body, (v, omega) = robot.m, scenario.body, scenario.limits.v_u1
    load = m * robot.g - most * (m * body.height + body.wheel_mass * robot.r) / body.caster
    if load <= 0.0:
        return 0.0
    lighter = load / 2 - m * v * omega * body.height / (2 * robot.l)
    across = m * v * omega / load
    left = body.tyre**2 - across * across
    return robot.r * max(lighter, 0.0) * math.sqrt(max(left, 0.0))
