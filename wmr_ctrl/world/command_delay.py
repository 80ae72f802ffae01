"""Delay of commands to a base that takes velocities: constant time from sending to acting.

Source: buses, radio and firmware.  The loop keeps commands in transit in its queue of plant steps,
which also carries torques to late drives.
"""

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.fields.values import check_count
from wmr_ctrl.core.signals import COMMAND

from .delay import queued
from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .history import MOST_REMEMBERED
from .model.system import Output, Parameters, System, ports


class CommandDelay(Section, key="base"):
    """Constant delay of the commanded velocity."""

    delay: float = queued("delay of the commanded velocity")


def build(scenario: Scenario) -> System:
    """Plant-rate System: the command that arrives [m/s, rad/s]."""
    command, p = ports(COMMAND), Parameters(scenario)
    late, title = p.take("base.delay"), "delay of the command"
    shown = tuple(Output(item.signal, item.sym) for item in command)
    return System(
        "command_delay", title, inputs=command, params=p.ports, outputs=shown, transport=late
    )


def check(scenario: Scenario) -> None:
    """Check that the controller can store the commands in transit, and torques have no delay."""
    late, period = scenario.section(CommandDelay).delay, scenario.clock.control
    check_count("base.delay", late, "clock.control", period, MOST_REMEMBERED)
    if not scenario.takes_velocity:
        return
    drives = scenario.actuator
    for name in ("delay", "unmodelled_delay", "jitter"):
        if getattr(drives, name) > 0:
            raise ScenarioError(
                f"actuator.{name} = {getattr(drives, name):g} s delays torques, and the base "
                'takes velocities (base.kind = "velocity"), whose speed loop makes the torques '
                f"itself. Delay the command by base.delay, or set actuator.{name} = 0."
            )


def bound(scenario: Scenario) -> Bound:
    """The delay itself."""
    return Bound(delay=scenario.section(CommandDelay).delay)


COMMAND_DELAY = Effect(
    "command delay", EffectRole.COMMAND, CommandDelay, build, bound, rate=Rate.STEP,
    shape=("base.delay",), check=check,
)  # fmt: skip
