"""The torque that was applied: what a law or a guard knows about the sample that has just ended.

The wheels' drives are known (actuator.delay, actuator.lag), so the torque that really acted follows
from what was commanded; nothing has to be measured.  The value is the mean over the control period
of the torque behind delay and lag, before noise, and 0 at the first sample.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import casadi as ca

from wmr_ctrl.control.setup import Setup
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Port, System, port
from wmr_ctrl.signals import TAU_APPLIED, Signal, tau_sent
from wmr_ctrl.world.delay import commands_under_way, delay_in_periods

ACTING = Signal("tau_acting", "N.m", "torque behind the lag at the end of the sample", 2)


class Applied:
    """``value`` is the mean torque (right, left) [N m] of the previous sample; a state of its own.

    With ideal drives that is the torque commanded one sample ago.  A delay adds the commands that
    are still under way, a lag the torque that acts when a sample ends.
    """

    def __init__(self, setup: Setup, p: Parameters, known: Iterable[Port] = ()) -> None:
        """State of the drives of a setup; ``known`` are a law's own ports of what it remembers.

        The guard may count commands for longer than they take, where another effect delays them,
        and a law may predict over more than there is.
        """
        own = {item.signal: item for item in known}
        scenario, clock = setup.scenario, setup.scenario.clock
        self.port = own.get(TAU_APPLIED) or port(TAU_APPLIED)
        self.steps = clock.substeps
        self.whole, self.part = delay_in_periods(scenario)
        drives = scenario.actuator
        counted = setup.guard.commands(clock, drives.delay, drives.lag)
        count = max(commands_under_way(scenario), counted, setup.predicted)
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
        late = commands[self.whole]
        if not (self.part or self.acting):
            return [late, *commands[: len(self.earlier)]]
        pieces = [(commands[self.whole + 1], self.part)] if self.part else []
        mean, end = self._through_lag([*pieces, (late, self.steps - self.part)])
        return [mean, *commands[: len(self.earlier)], *([end] if self.acting else [])]

    def _through_lag(self, pieces: Sequence[tuple[ca.SX, int]]) -> tuple[ca.SX, ca.SX]:
        """Mean over the sample and last value of torques that each last some plant steps."""
        acting = self.acting[0].sym if self.acting else ca.SX.zeros(2)
        total = ca.SX.zeros(2)
        for wanted, count in pieces:
            share = self.decay**count
            total = total + count * wanted
            if self.acting:
                total = total + self.decay * (1 - share) / (1 - self.decay) * (acting - wanted)
            acting = wanted + share * (acting - wanted)
        return total / self.steps, acting


def remembered(law: System) -> tuple[Port, ...]:
    """The inputs of a law that are such memory: what was applied, and what was sent."""
    sent = {tau_sent(age) for age in range(1, len(law.inputs) + 1)}
    return tuple(item for item in law.inputs if item.signal in {TAU_APPLIED, *sent})
