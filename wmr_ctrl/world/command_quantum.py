"""Quantised commands: each axis is rounded to the nearest integer multiple of a step.

Source: protocols that carry integers (mm/s), and drivers with few steps.
"""

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import COMMAND
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .model.system import Parameters, System, outputs, ports, stack


class CommandQuantum(Section, key="base"):
    """Step of the command."""

    quantum: tuple[float, float] = quantity(
        (0.0, 0.0), "m/s, rad/s", "commands are rounded to multiples of this, 0: none",
        minimum=0,
    )  # fmt: skip


def build(scenario: Scenario) -> System:
    """Plant-rate System: from arriving to acting command [m/s, rad/s]."""
    command, p = ports(COMMAND), Parameters(scenario)
    step, u = p.take("base.quantum"), stack(item.sym for item in command)
    size = ca.if_else(step > 0, step, 1)
    shown = outputs(COMMAND, ca.if_else(step > 0, size * ca.floor(u / size + 0.5), u))
    return System(
        "command_quantum", "quantised command", inputs=command, params=p.ports, outputs=shown
    )


def bound(scenario: Scenario) -> Bound:
    """Half a step: a command error, which the base's gain turns into a push."""
    v, omega = scenario.section(CommandQuantum).quantum
    return Bound(command=(v / 2, omega / 2))


COMMAND_QUANTUM = Effect(
    "command quantum", EffectRole.COMMAND, CommandQuantum, build, bound, rate=Rate.STEP
)
