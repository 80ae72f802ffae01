"""Mean torque applied over the last sample, as a law or a guard computes it.

The wheels' drives are known (actuator.delay, actuator.lag), so the applied torque follows from the
commands; no measurement is needed.  The value is the mean over the control period of the torque
behind delay and lag, before noise, and 0 at the first sample.
"""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, TypeAlias, TypeVar

import casadi as ca

from wmr_ctrl.core.signals import TAU_APPLIED, Signal, tau_sent
from wmr_ctrl.world.delay import commands_in_flight, delay_in_periods
from wmr_ctrl.world.model.system import Parameters, Port, System, port

from .setup import Setup

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ACTING = Signal("tau_acting", "N.m", "torque behind the lag at the end of the sample", 2)


class Applied:
    """Mean torque ``value`` (right, left) [N m] of the previous sample, with its own state.

    With ideal drives it is the torque commanded one sample ago.  A delay adds the commands in
    transit, a lag the torque at the end of a sample.
    """

    def __init__(self, setup: Setup, p: Parameters, known: Iterable[Port] = ()) -> None:
        """Create the state of a setup's drives; ``known`` are a law's ports for the same memory.

        The guard may assume longer delays than the drives have, if another effect delays commands.
        A law may predict over more commands than are in transit.
        """
        own = {item.signal: item for item in known}
        scenario, clock = setup.scenario, setup.scenario.clock
        self.port = own.get(TAU_APPLIED) or port(TAU_APPLIED)
        self.steps = clock.substeps
        self.whole, self.part = delay_in_periods(scenario)
        drives = scenario.actuator
        counted = setup.guard.commands(clock, drives.delay, drives.lag)
        count = max(commands_in_flight(scenario), counted, setup.predicted)
        sent = [tau_sent(age) for age in range(1, count + 1)]
        self.earlier = tuple(own.get(item) or port(item) for item in sent)
        self.acting = (port(ACTING),) if scenario.actuator.lag > 0 else ()
        self.decay = (
            ca.exp(-p.take("clock.plant") / p.take("actuator.lag")) if self.acting else ca.SX(0)
        )

    @property
    def value(self) -> ca.SX:
        """The mean torque of the previous sample (2,)."""
        return self.port.sym

    @property
    def state(self) -> tuple[Port, ...]:
        """All ports of the state, tau_applied first."""
        return (self.port, *self.earlier, *self.acting)

    def following(self, torque: ca.SX) -> list[ca.SX]:
        """Next state for the torque that is commanded now."""
        commands = [torque, *(item.sym for item in self.earlier)]
        rest = commands[: len(self.earlier)]
        if not (self.part or self.acting):
            return [commands[self.whole], *rest]
        acting = self.acting[0].sym if self.acting else ca.SX.zeros(2)
        mean, end = followed(commands, (self.whole, self.part, self.steps), acting, self.decay)
        return [mean, *rest, *([end] if self.acting else [])]


Lateness: TypeAlias = tuple[int, ca.SX | float, ca.SX | float]
"""A delay as whole control periods and plant steps beyond, and the plant steps of a period."""
Torque = TypeVar("Torque", ca.SX, "NDArray[np.float64]")


def followed(
    commands: Sequence[Torque], late: Lateness, acting: Torque, decay: ca.SX | float
) -> tuple[Torque, Torque]:
    """Mean torque over a sample, and the torque at its end behind a lag, for commands by age.

    The torque ``acting`` before decays by the factor ``decay`` per step, which is 0 without lag.
    """
    whole, part, steps = late
    pieces = [(commands[whole], steps - part)]
    if is_partial(part):
        pieces.insert(0, (commands[whole + 1], part))
    total = 0 * acting
    for wanted, count in pieces:
        share = decay**count
        total = total + count * wanted
        total = total + decay * (1 - share) / (1 - decay) * (acting - wanted)
        acting = wanted + share * (acting - wanted)
    return total / steps, acting


def is_partial(part: ca.SX | float) -> bool:
    """True if a delay in plant steps is not a whole number of periods; always for a symbol."""
    return isinstance(part, ca.SX) or part > 0


def remembered(law: System) -> tuple[Port, ...]:
    """Inputs of a law that hold past torques: applied ones and sent ones."""
    sent = {tau_sent(age) for age in range(1, len(law.inputs) + 1)}
    return tuple(item for item in law.inputs if item.signal in {TAU_APPLIED, *sent})
