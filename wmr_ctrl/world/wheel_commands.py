"""Firmware of each wheel: a dead band of its speed, and an acceleration limit.

Source: bases whose driver takes (v, omega) and drives each wheel separately, such as iRobot's
Create 3.  A wheel whose speed at the rim would be smaller than the dead band is kept at rest.  Its
command is ramped as `command_ramp` does for an axis.  Rims that start and stop at one rate keep v
and omega between the commands before and after.  At two rates one wheel may stop while the other
has hardly started, and |v| or |omega| exceeds both commands.
"""

from __future__ import annotations

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND, Signal
from wmr_ctrl.core.symbolic import ca

from .command_dead_band import heard
from .command_ramp import moved
from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Parameters, System, outputs, port, ports, stack

RAMPED = Signal("rim_ramped", "m/s", "speeds of the rims behind their acceleration limit", 2)


class WheelCommands(Section, key="base"):
    """Dead band and acceleration limits of each wheel, at its rim."""

    wheel_deadband: float = quantity(
        0.0, "m/s", "smaller speeds of a wheel's rim count as 0", minimum=0
    )
    wheel_accel: float = quantity(
        math.inf, "m/s2", "largest rate of a rim's commanded speed away from 0", above=0,
        infinite=True,
    )  # fmt: skip
    wheel_decel: float = quantity(
        math.inf, "m/s2", "largest rate of a rim's commanded speed towards 0", above=0,
        infinite=True,
    )  # fmt: skip


def build(scenario: Scenario) -> System:
    """System of the plant's rate: command that arrives to command that acts [m/s, rad/s]."""
    command, p, state = ports(COMMAND), Parameters(scenario), [port(RAMPED)] * ramps(scenario)
    l, band = p.take("robot.l"), p.take("base.wheel_deadband")
    acting = heard(to_rims(stack(item.sym for item in command), l), band)
    for ramped in state:
        h, accel, decel = map(p.take, ("clock.plant", "base.wheel_accel", "base.wheel_decel"))
        acting = moved(ramped.sym, acting, h * accel, h * decel)
    return System(
        "wheel_commands",
        "firmware of each wheel",
        inputs=command,
        state=tuple(state),
        params=p.ports,
        update=acting if state else ca.SX(0, 1),
        outputs=outputs(COMMAND, from_rims(acting, l)),
    )


def ramps(scenario: Scenario) -> bool:
    """True if a rate is limited: a rim then stops at 0 before its sign changes."""
    own = scenario.section(WheelCommands)
    return min(own.wheel_accel, own.wheel_decel) < math.inf


def to_rims(pair: ca.SX, l: ca.SX) -> ca.SX:
    """Speeds of the right and left rim [m/s] for (v, omega)."""
    return ca.vertcat(pair[0] + l * pair[1], pair[0] - l * pair[1])


def from_rims(rims: ca.SX, l: ca.SX) -> ca.SX:
    """The pair (v, omega) for speeds of the right and left rim [m/s]."""
    return ca.vertcat((rims[0] + rims[1]) / 2, (rims[0] - rims[1]) / (2 * l))


def bound(scenario: Scenario) -> Bound:
    """Half of the dead band: a wheel that is kept at rest may also speed the base up.

    With ramps of one rate, also the part of a plant step in which a rim is stopped at 0.
    """
    own, l = scenario.section(WheelCommands), scenario.robot.l
    half, accel = own.wheel_deadband / 2, own.wheel_accel
    error = half + (accel * scenario.clock.plant if accel < math.inf else 0)
    return Bound(
        command=(error, error / l),
        dropped=(half, half / l),
        hidden="base.wheel_accel, wheel_decel: the base ramps its wheels." * ramps(scenario),
    )


WHEEL_COMMANDS = Effect(
    "wheel commands", EffectRole.COMMAND, WheelCommands, build, bound, rate=Rate.STEP
)
