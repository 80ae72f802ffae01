"""Acceleration limit in the firmware: the acting command approaches the sent one at a bounded rate.

Source: motor drivers and velocity smoothers.  Away from 0 each axis changes by at most ``accel``,
towards 0 by at most ``decel``.  If the sign changes within a plant step, the command stops at 0
first.
"""

from __future__ import annotations

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.core.signals import COMMAND, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Parameters, System, outputs, port, ports, stack

RAMPED = Signal("v_ramped", "m/s, rad/s", "command behind the acceleration limit", 2)
FREE = (math.inf, math.inf)
ALIKE = 2e-12
"""Share by which rates may miss one another that are the same but for roundings."""


class CommandRamp(Section, key="base"):
    """Acceleration limits of the firmware."""

    accel: tuple[float, float] = quantity(
        FREE, "m/s2, rad/s2", "largest rate of the command away from 0", above=0,
        infinite=True,
    )  # fmt: skip
    decel: tuple[float, float] = quantity(
        FREE, "m/s2, rad/s2", "largest rate of the command towards 0", above=0,
        infinite=True,
    )  # fmt: skip


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving to acting command [m/s, rad/s]."""
    command, ramped, p = ports(COMMAND), port(RAMPED), Parameters(scenario)
    h, accel, decel = (p.take(key) for key in ("clock.plant", "base.accel", "base.decel"))
    wanted = stack(item.sym for item in command)
    following = moved(ramped.sym, wanted, h * accel, h * decel)
    return System(
        "command_ramp",
        "acceleration limit of the firmware",
        inputs=command,
        state=(ramped,),
        params=p.ports,
        update=following,
        outputs=outputs(COMMAND, following),
    )


def moved(now: ca.SX, wanted: ca.SX, grow: ca.SX, shrink: ca.SX) -> ca.SX:
    """The command after a step in which its size may grow by ``grow`` and shrink by ``shrink``."""
    top = ca.if_else(now >= 0, now + grow, ca.fmin(now + shrink, 0))
    bottom = ca.if_else(now <= 0, now - grow, ca.fmax(now - shrink, 0))
    return ca.fmax(bottom, ca.fmin(top, wanted))


def keeps_wheels(scenario: Scenario) -> bool:
    """True if no wheel exceeds a limit that both commands satisfy, while one is ramped to the
    other.

    Each of v and omega stops at least as fast as the other starts, at the wheels' rim
    (`filter.ramp-rim`), up to rounding.
    """
    own, l = scenario.section(CommandRamp), scenario.robot.l
    linear, angular = (rate * (1 + ALIKE) for rate in own.decel)
    return own.accel[0] <= l * angular and l * own.accel[1] <= linear


def quick_stops(scenario: Scenario) -> str:
    """Further remedy: a sufficient base.decel; empty if commands grow without limit."""
    own, l = scenario.section(CommandRamp), scenario.robot.l
    least = l * own.accel[1], own.accel[0] / l
    if min(least) == math.inf:
        return ""
    return f", or state base.decel = [{', '.join(rounded(rate, 4) for rate in least)}] or more"


def bound(scenario: Scenario) -> Bound:
    """Hidden effect: a state that the governor does not model.  A ramp never overshoots its
    input.
    """
    key = "accel" if min(scenario.section(CommandRamp).accel) < math.inf else "decel"
    return Bound(hidden=f"base.{key}: the base ramps its command.")


COMMAND_RAMP = Effect("command ramp", EffectRole.COMMAND, CommandRamp, build, bound, rate=Rate.STEP)
