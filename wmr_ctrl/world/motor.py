"""Motors: quantised torque, a dead zone, and torque that falls with wheel speed.

Source: a current controller's resolution, a gear's static friction, and the straight line between
the stall torque and the free speed of a direct-current motor, at the wheel.  A motor brakes
with its full stall torque.
"""

from __future__ import annotations

import math

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import TORQUE, VELOCITY
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Number, Parameters, System, outputs, ports, stack


class Motor(Section, key="motor"):
    """Resolution, dead zone and torque line of the motors; the defaults change nothing."""

    step: float = quantity(
        0.0, "N.m", "torque comes in whole steps of this, the nearest; 0: any", minimum=0
    )
    dead_zone: float = quantity(
        0.0, "N.m", "what is lost of each torque; a smaller one does nothing", minimum=0
    )
    stall: float = quantity(
        math.inf, "N.m", "torque at rest; inf: no limit", above=0, infinite=True
    )
    free: float = quantity(
        math.inf,
        "rad/s",
        "speed of the wheel at which no torque is left; inf: any",
        above=0,
        infinite=True,
        usual=(0, 100),
    )


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving torque and true velocity to the motors' torque."""
    motor, torque, velocity = scenario.section(Motor), ports(TORQUE), ports(VELOCITY)
    p = Parameters(scenario)
    r, half_track = p.take("robot.r"), p.take("robot.l")
    v, turn = velocity[0].sym, half_track * velocity[1].sym
    given, speed = stack(item.sym for item in torque), ca.vertcat(v + turn, v - turn) / r
    if motor.step > 0:
        given = stepped(given, p.take("motor.step"))
    if motor.dead_zone > 0:
        given = beyond_zone(given, p.take("motor.dead_zone"))
    if math.isfinite(motor.stall):
        slowing = 1 / p.take("motor.free") if math.isfinite(motor.free) else ca.SX(0)
        given = on_line(given, speed, p.take("motor.stall"), slowing)
    shown = outputs(TORQUE, given)
    return System(
        "motor", "motors of the wheels", inputs=(*torque, *velocity), params=p.ports, outputs=shown
    )


def stepped(torque: ca.SX, step: ca.SX) -> ca.SX:
    """The torque rounded to an integer number of steps [N m]."""
    return step * ca.floor(torque / step + 0.5)


def beyond_zone(torque: ca.SX, zone: ca.SX) -> ca.SX:
    """Torque behind a dead zone [N m]."""
    return torque - ca.fmax(-zone, ca.fmin(zone, torque))


def on_line(torque: ca.SX, speed: ca.SX, stall: ca.SX, slowing: ca.SX) -> ca.SX:
    """Torque [N m] of a motor whose wheel turns at ``speed`` [rad/s]; ``slowing`` = 1/free.

    At most stall (1 - speed/free) in the direction of rotation, at most stall against it.
    """
    ahead = stall * ca.fmax(1 - slowing * ca.fmax(speed, 0), 0)
    back = stall * ca.fmax(1 - slowing * ca.fmax(-speed, 0), 0)
    return ca.fmax(-back, ca.fmin(ahead, torque))


def check(scenario: Scenario) -> None:
    """Check that a free speed comes with a stall torque."""
    motor = scenario.section(Motor)
    if math.isfinite(motor.free) and math.isinf(motor.stall):
        raise ScenarioError(
            f"motor.free = {motor.free!r} rad/s does nothing without motor.stall: torque falls "
            "from stall at rest to 0 at this speed. State motor.stall [N m], or leave both out."
        )


def largest_torque(scenario: Scenario) -> float:
    """Quantised torque limit of a motor [N m]; inf without one."""
    return scenario.actuator.tau_max + rounded_by(scenario.section(Motor).step)


def bound(scenario: Scenario) -> Bound:
    """Largest force that both wheels together lack.

    Rounding to a step errs by at most half of it, and the dead zone removes at most its width: the
    thrust lacks twice that over r, the moment l times as much.  For a torque up to tau_max, a wheel
    at speed s lacks at most that plus d(s) = max(tau_max - stall (1 - s/free), 0), which is convex
    and rising in s.  Within the limits the wheels turn the same way at up to u1 + l w and u1 - l w,
    opposite ways at up to v + l u2 and l u2 - v.  A convex sum is largest at an end, here the
    fastest wheel with the other one (ledger: world.motor.*).
    """
    motor, robot, (u1, u2) = scenario.section(Motor), scenario.robot, scenario.limits.v_u1
    limit = largest_torque(scenario)

    def short(speed: float) -> float:  # d [N m] at a wheel's speed; against its turn as at rest
        endless = math.isinf(motor.stall)
        return 0.0 if endless else missing(limit, motor.stall, speed / motor.free)

    lost = 2.0 * (rounded_by(motor.step) + motor.dead_zone)
    fast, edge = u1 + robot.l * u2, u1 - robot.l * u2
    most = 2.0 * limit
    sums = (sum(short(s / robot.r) for s in (fast, way * edge)) for way in (1.0, -1.0))
    pair = [lost + min(item, most) for item in sums]
    if math.isinf(pair[0]):
        return Bound(
            void=f"motor.stall = {motor.stall:g} N m: the motors get torques without limit "
            "(actuator.tau_max = inf), so their shortfall has no bound."
        )
    return Bound(dbar=(pair[0] / robot.r, pair[1] / robot.r * robot.l))


def missing(most: Number, stall: Number, share: Number) -> Number:
    """d [N m] for a torque up to ``most`` at a ``share`` of the free speed; numbers or symbols."""
    return positive(most - stall * (1.0 - positive(share)))


def rounded_by(step: Number) -> Number:
    """Largest rounding error of torque in steps [N m]."""
    return step / 2.0


def positive(value: Number) -> Number:
    """The positive part of a value: exact."""
    return (value + abs(value)) / 2.0


MOTOR = Effect("motor", EffectRole.DRIVE, Motor, build, bound, rate=Rate.STEP, check=check)
