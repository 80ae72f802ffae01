"""Lost commands, and the base's time-out: it keeps the last received command, then stops.

Source: radio and buses.  Each command is lost with probability 1/2, but never more than ``losses``
in a row; a base that received nothing for ``timeout`` uses 0 as its command until one arrives.
"""

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND, STEP, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import ROUNDING, Bound, Effect, EffectRole, Rate, Scenario
from .jitter import whole
from .model.system import (
    UNIFORM,
    Parameters,
    System,
    draw,
    outputs,
    port,
    ports,
    stack,
)

NUMBERS = Signal("command_loss", "1", "uniform numbers on [-1, 1) of a sample", 2)
HEARD = Signal("v_heard", "m/s, rad/s", "last command that was not lost", 2)
SILENT = Signal("command_silence", "1", "plant steps since the last command that was not lost")
MISSED = Signal("commands_missed", "1", "commands lost in a row")


class CommandLoss(Section, key="base"):
    """Largest number of commands lost in a row, and the time-out."""

    losses: int = quantity(0, "1", "largest number of consecutive lost commands", minimum=0)
    timeout: float = quantity(
        math.inf, "s", "time without a command after which the base stops; inf: never", above=0,
        infinite=True, usual=(0, 10),
    )  # fmt: skip


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving to acting command [m/s, rad/s]."""
    command, step, p = ports(COMMAND), port(STEP), Parameters(scenario)
    heard, silent, missed = port(HEARD), port(SILENT), port(MISSED)
    T, h, late = map(p.take, ("clock.control", "clock.plant", "base.delay"))
    most, timeout = p.take("base.losses"), p.take("base.timeout")
    number = draw(NUMBERS, UNIFORM, most > 0, held=True)
    since = step.sym - whole(late / h)
    arrives = since - whole(T / h) * ca.floor(since / whole(T / h)) == 0
    lost = ca.logic_and(number.port.sym[0] < 0, missed.sym < most)
    comes = ca.logic_and(arrives, ca.logic_not(lost))
    now = ca.if_else(comes, stack(item.sym for item in command), heard.sym)
    silence = ca.if_else(comes, 0, silent.sym + 1)
    missing = ca.if_else(comes, 0, missed.sym + ca.logic_and(arrives, lost))
    acting = ca.if_else(silence * h > timeout, 0, now)
    return System(
        "command_loss",
        "lost commands and time-out",
        inputs=(*command, step),
        state=(heard, silent, missed),
        params=p.ports,
        update=ca.vertcat(now, silence, missing),
        outputs=outputs(COMMAND, acting),
        draws=(number,),
    )


def bound(scenario: Scenario) -> Bound:
    """The number of losses.  A stop between commands is a hidden effect."""
    own, period = scenario.section(CommandLoss), scenario.clock.control
    stops = own.timeout < (own.losses + 1) * period * (1 - ROUNDING)
    sentence = "base.timeout: the base stops before the next command that is not lost."
    return Bound(losses=own.losses, hidden=sentence if stops else "")


def acts(scenario: Scenario) -> bool:
    """True if commands are lost, or the base stops between two of them."""
    own = scenario.section(CommandLoss)
    return own.losses > 0 or own.timeout < scenario.clock.control


COMMAND_LOSS = Effect(
    "command loss", EffectRole.COMMAND, CommandLoss, build, bound, acts=acts, rate=Rate.STEP,
    shape=("clock.control", "clock.plant"),
)  # fmt: skip
