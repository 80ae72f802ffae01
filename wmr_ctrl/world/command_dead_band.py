"""Dead band of commands: a smaller velocity is replaced by 0, on each axis separately.

Source: firmware that does not let motors hum at rest.
"""

from __future__ import annotations

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Parameters, System, outputs, ports, stack


class CommandDeadBand(Section, key="base"):
    """Size of the dead band."""

    deadband: tuple[float, float] = quantity(
        (0.0, 0.0), "m/s, rad/s", "smaller commands count as 0", minimum=0
    )


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving to acting command [m/s, rad/s]."""
    command, p = ports(COMMAND), Parameters(scenario)
    band, u = p.take("base.deadband"), stack(item.sym for item in command)
    title, shown = "dead band of the command", outputs(COMMAND, heard(u, band))
    return System("command_dead_band", title, inputs=command, params=p.ports, outputs=shown)


def heard(u: ca.SX, band: ca.SX) -> ca.SX:
    """The command that acts behind the dead band."""
    return ca.if_else(ca.fabs(u) < band, 0, u)


def bound(scenario: Scenario) -> Bound:
    """Command error of the size of the dead band, since a command may act as 0."""
    v, omega = scenario.section(CommandDeadBand).deadband
    return Bound(dropped=(v, omega))


COMMAND_DEAD_BAND = Effect(
    "command dead band", EffectRole.COMMAND, CommandDeadBand, build, bound, rate=Rate.STEP
)
