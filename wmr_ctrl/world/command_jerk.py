"""Jerk limit in the firmware: it limits how fast the rate of the acting command changes.

Source: motor drivers with S-shaped profiles.  Per axis the rate a of the command y changes by at
most q = jerk h in a plant step h.  The rate is limited so that y can stop at its goal, at the
distance ``way``:

    a+ = the largest rate with h (a+ + (a+ - q)^+ + (a+ - 2 q)^+ + ...) <= way, within a -+ q
    y+ = y + h a+

That sum is the distance that y moves if a+ is then reduced as fast as possible.  While y moves
towards a goal it never passes the goal, and braking does not change the sum.  So for any input y
stays between the least and the largest of 0 and the commands so far.  If the goal moves, y may
continue away from it for a while.  The rate itself is at most the larger of accel and decel.
"""

from __future__ import annotations

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND, LARGEST, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Parameters, System, outputs, port, ports, stack

ROUNDED = Signal("v_rounded", "m/s, rad/s", "command behind the jerk limit", 2)
RATE = Signal("v_rounded_rate", "m/s2, rad/s2", "rate of the command behind the jerk limit", 2)


class CommandJerk(Section, key="base"):
    """Jerk limits of the firmware."""

    jerk: tuple[float, float] = quantity(
        (math.inf, math.inf), "m/s3, rad/s3", "largest change of the command's rate",
        above=0, infinite=True,
    )  # fmt: skip


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving to acting command [m/s, rad/s]."""
    command, now, rate, p = ports(COMMAND), port(ROUNDED), port(RATE), Parameters(scenario)
    h, jerk, accel, decel = map(p.take, ("clock.plant", "base.jerk", "base.accel", "base.decel"))
    wanted, most = stack(item.sym for item in command), ca.fmax(accel, decel)
    rates = next_rate(wanted - now.sym, rate.sym, h, jerk, most)
    following = now.sym + h * rates
    return System(
        "command_jerk",
        "jerk limit of the firmware",
        inputs=command,
        state=(now, rate),
        params=p.ports,
        update=ca.vertcat(following, rates),
        outputs=outputs(COMMAND, following),
    )


def next_rate(away: ca.SX, rate: ca.SX, h: ca.SX, jerk: ca.SX, most: ca.SX) -> ca.SX:
    """a+ for a goal at the distance ``away`` [m/s]; with infinite ``jerk`` the goal is reached
    immediately.
    """
    q, side = ca.fmin(jerk, LARGEST) * h, ca.if_else(away >= 0, 1, -1)
    way, towards = ca.fabs(away), side * rate
    steps = ca.fmax(1, -ca.floor(-(ca.sqrt(1 + 8 * way / (h * q)) - 1) / 2))
    largest = (way / h + q * steps * (steps - 1) / 2) / steps
    return side * ca.fmax(towards - q, ca.fmin(ca.fmin(largest, most), towards + q))


def bound(scenario: Scenario) -> Bound:
    """Hidden effect: a state that the governor does not model; commands keep their past range."""
    return Bound(hidden="base.jerk: the base rounds its ramps.")


COMMAND_JERK = Effect("command jerk", EffectRole.COMMAND, CommandJerk, build, bound, rate=Rate.STEP)
