"""Delay of the drives: a command acts a constant time after it was given.

The loop keeps commands in transit in a queue of plant steps, which a graph cannot represent well;
this System passes them on.
"""

from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.fields.values import check_count
from wmr_ctrl.core.signals import TORQUE

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .history import MOST_REMEMBERED, multiple
from .model.system import Output, Parameters, System, ports

MOST_QUEUED = 100_000
"""Plant steps that a command may spend in transit."""


def queued(doc: str) -> float:
    """Field of a section: time [s] that a command spends in the loop's queue."""
    return multiple(doc, "clock.plant", maximum=10, usual=(0, 2), most=MOST_QUEUED)


class Delay(Section, key="actuator"):
    """Constant delay of the torque."""

    delay: float = queued("delay of the torque")
    unmodelled_delay: float = queued("further delay, unknown to laws and observer")


def build(scenario: Scenario) -> System:
    """Plant-rate System: the torque that arrives [N m]."""
    torque, p = ports(TORQUE), Parameters(scenario)
    late = p.take("actuator.delay") + p.take("actuator.unmodelled_delay")
    shown = tuple(Output(item.signal, item.sym) for item in torque)
    return System(
        "delay", "delay of the drives", inputs=torque, params=p.ports, outputs=shown, transport=late
    )


def check(scenario: Scenario) -> None:
    """Check that an observer can store all commands in transit."""
    late, period = scenario.section(Delay).delay, scenario.clock.control
    check_count("actuator.delay", late, "clock.control", period, MOST_REMEMBERED)


def bound(scenario: Scenario) -> Bound:
    """The delay itself, whether laws know it or not: the guard takes every command in transit into
    account.
    """
    late = scenario.section(Delay)
    return Bound(delay=late.delay + late.unmodelled_delay)


SHAPE = ("actuator.delay", "actuator.unmodelled_delay")
DELAY = Effect(
    "delay", EffectRole.DRIVE, Delay, build, bound, rate=Rate.STEP, shape=SHAPE, check=check
)


def delay_in_periods(scenario: Scenario) -> tuple[int, int]:
    """The stated delay as whole control periods and the remaining plant steps."""
    return in_periods(scenario.section(Delay).delay, scenario)


def in_periods(late: float, scenario: Scenario) -> tuple[int, int]:
    """A time [s] as whole control periods and remaining plant steps."""
    clock = scenario.clock
    return divmod(round(late / clock.plant), clock.substeps)


def commands_in_flight(scenario: Scenario) -> int:
    """Number of commands that still act, or will act, when the next one is computed."""
    whole, part = delay_in_periods(scenario)
    return whole + bool(part)
