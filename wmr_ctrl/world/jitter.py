"""Jitter: each command arrives later than actuator.delay by a bounded random time.

Source: computation and buses; the time is uniform over whole plant steps from 0 to ``jitter`` and
drawn for each command.  A command never overtakes the one before it, since jitter <= clock.control.
"""

from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.signals import STEP, TORQUE, Signal
from wmr_ctrl.core.symbolic import ca

from .effect import Bound, Effect, EffectRole, Rate, Scenario
from .history import multiple
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

NUMBERS = Signal("jitter", "1", "uniform numbers on [-1, 1) of a sample", 2)
ACTING = Signal("jitter_acting", "N.m", "torque that acts (right, left)", 2)
WAITING = Signal("jitter_waiting", "N.m", "torque that arrived last (right, left)", 2)
DUE = Signal("jitter_due", "1", "plant steps from its arrival until it acts")


class Jitter(Section, key="actuator"):
    """Largest further delay of a command."""

    jitter: float = multiple("largest delay of a command beyond delay", "clock.plant", usual=(0, 2))


def build(scenario: Scenario) -> System:
    """Plant-rate System: from torque behind the constant delay to acting torque [N m].

    In the plant step in which a command arrives, the number drawn for the sample gives its waiting
    time; until then the previous torque acts.
    """
    torque, step, p = ports(TORQUE), port(STEP), Parameters(scenario)
    acting, waiting, due = port(ACTING), port(WAITING), port(DUE)
    T, h, delay = map(p.take, ("clock.control", "clock.plant", "actuator.delay"))
    unmodelled_delay, width = p.take("actuator.unmodelled_delay"), p.take("actuator.jitter")
    number = draw(NUMBERS, UNIFORM, width > 0, held=True)
    steps, most = whole(T / h), whole(width / h)
    since = step.sym - whole((delay + unmodelled_delay) / h)
    phase = since - steps * ca.floor(since / steps)
    arrives = phase == 0
    drawn = ca.fmin(ca.floor((number.port.sym[0] + 1) / 2 * (most + 1)), steps)
    before = ca.if_else(ca.logic_and(arrives, due.sym >= steps), waiting.sym, acting.sym)
    wait = ca.if_else(arrives, drawn, due.sym)
    arrived = stack(item.sym for item in torque)
    now = ca.if_else(phase >= wait, arrived, before)
    return System(
        "jitter",
        "jitter of the drives' delay",
        inputs=(*torque, step),
        state=(acting, waiting, due),
        params=p.ports,
        update=ca.vertcat(now, arrived, wait),
        outputs=outputs(TORQUE, now),
        draws=(number,),
    )


def whole(number: "ca.SX") -> "ca.SX":
    """The nearest integer."""
    return ca.floor(number + 0.5)


def check(scenario: Scenario) -> None:
    """Refuse jitter of more than one control period."""
    jitter, clock = scenario.section(Jitter).jitter, scenario.clock
    if jitter > clock.control:
        raise ScenarioError(
            f"actuator.jitter = {jitter!r} s must be at most clock.control = {clock.control!r} s: "
            "a command could otherwise overtake the one before it. "
            f"Lower it to {clock.control:g} s, or put the constant part into actuator.delay."
        )


def bound(scenario: Scenario) -> Bound:
    """The jitter: the largest delay grows by it, and a command may be earlier than the largest
    delay by it.
    """
    jitter = scenario.section(Jitter).jitter
    return Bound(delay=jitter, jitter=jitter)


SHAPE = ("clock.control", "clock.plant")
JITTER = Effect(
    "jitter", EffectRole.DRIVE, Jitter, build, bound, rate=Rate.STEP, shape=SHAPE, check=check
)
