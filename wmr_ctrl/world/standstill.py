"""Standstill control: after commands of 0 the base stands and holds, until another one arrives.

Source: motor drivers with a brake, a time-out or control at standstill.  Once both commands that
arrive have been 0 for `rest`, the base stops instantly, and nothing moves it; any other command
opens the brake.  The time is measured before ramps of the firmware, so that slowing down is part of
it.
"""

from __future__ import annotations

import math

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import ROUNDING, Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Output, Parameters, System, port, ports

ZEROS = Signal("zero_steps", "1", "plant steps in a row with a command of (0, 0)")
BRAKED = Signal("braked", "1", "1: the base stands and holds")


class Standstill(Section, key="base"):
    """Time until a base without commands holds."""

    rest: float = quantity(
        math.inf, "s", "time with commands of 0 after which the base stands and holds; inf: never",
        minimum=0, infinite=True, usual=(0, 10),
    )  # fmt: skip


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving commands to whether the base is held."""
    command, zeros, p = ports(COMMAND), port(ZEROS), Parameters(scenario)
    nothing = ca.logic_and(*(item.sym == 0 for item in command))
    steps = ca.floor(p.take("base.rest") / p.take("clock.plant") + ROUNDING)
    return System(
        "standstill",
        "control at standstill",
        inputs=command,
        state=(zeros,),
        params=p.ports,
        update=ca.if_else(nothing, zeros.sym + 1, 0),
        diagnostics=(Output(BRAKED, ca.logic_and(nothing, zeros.sym >= steps)),),
    )


def bound(scenario: Scenario) -> Bound:
    """Empty if the filter knows `filter.rest`; otherwise a stop between commands is hidden."""
    hidden = "base.rest: the base may stand at once, and filter.rest does not say when."
    return Bound(hidden="" if scenario.filter.rest is not None else hidden)


STANDSTILL = Effect("standstill", EffectRole.COMMAND, Standstill, build, bound, rate=Rate.STEP)
