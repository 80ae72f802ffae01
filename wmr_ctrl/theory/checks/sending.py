"""Loop of a law on a base that takes velocities, while the base limits no command.

The command is computed by the controller's own graph without its filter, which passes every command
within the limits (ledger: corridor.filter).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np

from wmr_ctrl.control.applied import remembered
from wmr_ctrl.control.controller import law_graph, unfiltered_controller, velocity_sender
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.signals import ASKED, SENT_BEFORE, places
from wmr_ctrl.world.model.system import Output, System
from wmr_ctrl.world.scenario import Robot, unknown_keys

from .budget import counted
from .error_coordinates import Floats
from .loop import Loop
from .rest import rest
from .sampled_plant import Point, steps_in
from .surroundings import idle_base

LONG = 0.1
"""A control period in which laws may change their command much [s]."""


@dataclass(frozen=True)
class SendingLoop(Loop):
    """Loop of a law whose output is the velocity command.

    ``sender``: a graph to use instead of the controller's; ``period`` and ``delay`` of commands for
    which it is built [s], by default the scenario's.
    """

    sender: System | None = None
    period: float | None = None
    delay: float | None = None

    @cached_property
    def core(self) -> System:
        """Law and adapter with their memory, for a base that limits no command."""
        if self.sender is not None:
            return self.sender
        law = _law_graph(self.setup, self.in_flight)
        idle = replace(self.setup, scenario=idle_base(self.scenario))
        sent = velocity_sender(idle, law, self._late)
        return replace(sent.system(), outputs=(Output(ASKED, sent.asked),), diagnostics=())

    @cached_property
    def own_period(self) -> float:
        """Control period that it is built for [s]."""
        return self.scenario.clock.control if self.period is None else self.period

    @property
    def _late(self) -> tuple[int, float, float] | None:
        """Delay of commands in whole periods and further plant steps, and plant steps per period.

        None if they are the scenario's.
        """
        if self.period is None and self.delay is None:
            return None
        delay = self.scenario.base.delay if self.delay is None else self.delay
        steps = steps_in(self.own_period, self.scenario.clock.plant)
        whole, part = divmod(round(delay / (self.own_period / steps)), steps)
        return whole, part, steps

    def at_period(self, period: float) -> Loop:
        """The loop for a control period [s]; it remembers the commands in transit."""
        own = self.scenario.base.delay if self.delay is None else self.delay
        same = period == self.scenario.clock.control
        return self if same or own == 0 or not self._remembers else _made_for(self, period, own)

    @property
    def longest(self) -> float:
        """The base's time-out, beyond which it stops between two commands."""
        return self.scenario.base.timeout

    def with_delay(self, delay: float) -> Loop:
        """The loop of a law that assumes a delay of its commands [s]."""
        return _made_for(self, self.period, delay) if self._remembers else self

    @property
    def _remembers(self) -> bool:
        return bool(remembered(_law_graph(self.setup, self.in_flight)))

    def on_reference(self, v_d: Floats, theta: float = 0.0) -> Point:
        """Operating point on the reference after a long time of constant commands."""
        key = tuple(map(float, v_d))
        if key not in self._points:
            self._points[key] = self._driving(np.array(key))
        return self._points[key].turned(theta)

    @property
    def learns(self) -> bool:
        """True if the law has estimates, which are part of its equilibrium and so must move."""
        return self.traits.estimates

    def resting(
        self, v_d: Floats, theta: float, period: float, robot: Robot | None = None
    ) -> Point | None:
        """The true equilibrium; its commands are equal, so their delay does not matter."""
        own = self._own
        at = _at_rest(own, tuple(map(float, v_d)), theta, period, robot)
        if at is None or self is own:
            return at
        rows = places(item.signal for item in own.core.state)
        known = [at.memory[rows[name]] if (name := item.signal.name) in rows else at.force
                 for item in self.core.state]  # fmt: skip
        return replace(at, memory=np.concatenate((np.zeros(0), *known)))

    @cached_property
    def _own(self) -> Loop:
        """The loop for the scenario's own period and delay."""
        return loop_of(self.setup)

    def _driving(self, speed: Floats) -> Point:
        own = [speed if item.signal.name.startswith(SENT_BEFORE.name) else np.array(item.value)
               for item in self.core.state]  # fmt: skip
        there = Point(np.zeros(3), speed, speed, np.zeros(2), np.concatenate(own), speed)
        return replace(self.after_a_sample(self.after_a_sample(there)), force=speed)


@counted
def _at_rest(
    loop: Loop, v_d: tuple[float, ...], theta: float, period: float, robot: Robot | None
) -> Point | None:
    """Equilibrium of a loop whose commands act without delay.

    In a short period a law may change its command too little for Newton's method.  The iteration
    then starts from the equilibrium of a long period, which is near.
    """
    find, on = partial(rest, loop, loop.around), loop.on_reference(np.array(v_d), theta)
    at = find(on, period, robot)
    if at is None and period < LONG and (near := find(on, LONG, robot)):
        at = find(near, period, robot)
    return at


@lru_cache(maxsize=16)
def _law_graph(setup: Setup, in_flight: int | None) -> System:
    return law_graph(replace(setup, scenario=idle_base(setup.scenario)), in_flight)


@lru_cache(maxsize=128)
def _made_for(loop: SendingLoop, period: float | None, delay: float) -> SendingLoop:
    return replace(loop, period=period, delay=delay)


@lru_cache(maxsize=128)
def loop_of(setup: Setup) -> Loop:
    """The Loop of a setup, built once.

    Raises MissingKeysError if the law needs a number of the robot that nobody states.
    """
    if unknown_keys(setup.scenario):
        unfiltered_controller(setup)
    return SendingLoop(setup) if setup.takes_velocity else Loop(setup)
