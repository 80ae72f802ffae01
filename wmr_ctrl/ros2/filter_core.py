"""Decisions of ``wmr_filter``: messages and ticks to the command that goes to the base.

Nothing here knows ROS: the node hands on what came and when.
"""

from __future__ import annotations

from wmr_ctrl.filter.gate import Gated, GateSettings
from wmr_ctrl.ros2.clocks import BACK, FROZEN, NS, Clocks, Moment
from wmr_ctrl.ros2.compiled_gate import PAIR, Gate
from wmr_ctrl.ros2.intake import Intake
from wmr_ctrl.scenario import Scenario


def in_ns(seconds: float) -> int:
    """A time in nanoseconds."""
    return round(seconds / NS)


def longest_pause(timeout: float, period: float) -> int:
    """Pause between callbacks [ns] that is no freeze, for a time-out and a period [s]."""
    return in_ns(max(timeout, 2.5 * period))


class FilterCore:
    """Gate, intakes and clocks of a filter node.

    ``stop`` is what the topic ~/stop says, ``scale`` the share of each command that is passed on.
    """

    def __init__(self, scenario: Scenario, settings: GateSettings, frame: str = "") -> None:
        """Compile the gate; ``frame``: the base's.  Raises ScenarioError, CompilerError."""
        self.gate = Gate(scenario, settings)
        self.commands = Intake(in_ns(settings.command_timeout), PAIR, frame)
        self.odometry = Intake(in_ns(settings.odometry_timeout), PAIR, frame)
        self.clocks = Clocks(longest_pause(settings.command_timeout, self.gate.period))
        self.last, self.stop, self.scale = Gated(PAIR, ()), False, 1.0
        self.start()

    def start(self) -> None:
        """Begin anew: no command, no odometry, nothing latched."""
        self.gate.start()
        self.clocks.start()
        self.forget()
        self._reset, self._before = False, 0

    def forget(self) -> None:
        """Count no message that came before."""
        self.commands.forget()
        self.odometry.forget()

    def see(self, now: Moment) -> tuple[str, ...]:
        """Look at the time; what happened to it, to be told.

        After a jump back what came before counts no more.  After a freeze the gate sees how old
        everything is, and messages without a stamp that waited are refused.
        """
        happened = self.clocks.see(now)
        if BACK in happened:
            self.forget()
        if FROZEN in happened:
            self.commands.thaw()
            self.odometry.thaw()
        return happened

    def halt(self, stop: bool, now: Moment) -> Gated | None:
        """Take the word of ~/stop; true stops at once."""
        self.stop = stop
        return self.tick(now) if stop else None

    def reset(self) -> bool:
        """Leave at the next tick what a stop or a base too fast has latched.

        False while ~/stop says true: then it stays stopped.
        """
        self._reset = True
        return not self.stop

    def tick(self, now: Moment) -> Gated:
        """The command for the base."""
        elapsed = (now.steady - self._before) * NS if self._before else 0.0
        self._before = now.steady
        v, omega = self.commands.value
        self.last = self.gate.step(
            (self.scale * v, self.scale * omega), self.commands.age(now),
            self.odometry.value, self.odometry.age(now), elapsed,
            stop=self.stop, reset=self._reset,
        )  # fmt: skip
        self._reset = False
        return self.last
