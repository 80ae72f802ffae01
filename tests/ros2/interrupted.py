"""The filter's process when signals or exceptions come at bad moments; run by one with rclpy.

``python interrupted.py SCENARIO`` runs the filter once per case, as its command does, and prints
exit code, last command, number of its commands, and failures, as JSON. SIGALRM kills a process that
does not end.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time

from wmr_ctrl.ros2.filter_node import FilterNode
from wmr_ctrl.ros2.spin import AT_ONCE, spin

PATIENCE = 300
"""Time [s] after which the process is killed: a machine that is busy, and no more."""
LONG = 60.0
"""Time [s] that a node looks around, where it is to be interrupted in it: the longest there is."""


def interrupt(*numbers):
    for number in numbers or (signal.SIGINT,):
        os.kill(os.getpid(), number)


class Dropped:
    """An object that interrupts its process when it is destroyed."""

    def __del__(self):
        interrupt()


class Watched(FilterNode):
    """The filter, which does something in the callback that sends its first command."""

    commands: list[tuple[float, float]]
    failed: list[str]
    looks = 0.0
    ticked = False

    def send(self, command):
        Watched.commands.append(command)
        super().send(command)
        if not self.ticked:
            self.ticked = True
            self.send((0.25, 0.0))  # a zero after it is the last one
            self.first_tick()

    def fail(self, text):
        Watched.failed.append(text)
        super().fail(text)

    def first_tick(self):
        raise NotImplementedError


class InADestructor(Watched):
    def first_tick(self):
        Dropped()


class TwoAtOnce(Watched):
    """Three interrupts arrive together, as from a terminal and a launch file."""

    def first_tick(self):
        interrupt(signal.SIGINT, signal.SIGINT, signal.SIGTERM)


class InWhatTakesLong(Watched):
    def first_tick(self):
        interrupt()
        while True:
            time.sleep(AT_ONCE)
            interrupt(signal.SIGTERM)


class InATransition(Watched):
    """Interrupts arrive within on_deactivate, a state from which a node cannot be deactivated."""

    def first_tick(self):
        self.trigger_deactivate()

    def on_deactivate(self, state):
        if self.ticked and self.active:
            interrupt()
            time.sleep(AT_ONCE)
            interrupt()
        return super().on_deactivate(state)


class AtTheEnd(Watched):
    """An interrupt arrives while the node waits for its last zero."""

    def first_tick(self):
        interrupt()

    def rest(self):
        super().rest()
        interrupt(signal.SIGTERM)


class AtConfigure(Watched):
    looks = LONG

    def _look(self):
        interrupt()
        super()._look()


class BrokenAtConfigure(Watched):
    def _look(self):
        raise RuntimeError("broken")


class BrokenAtActivate(Watched):
    def _look(self):
        def breaks():
            raise RuntimeError("broken")

        self.core.start = breaks


CASES = (
    InADestructor, TwoAtOnce, InWhatTakesLong, InATransition, AtTheEnd, AtConfigure,
    BrokenAtConfigure, BrokenAtActivate,
)  # fmt: skip


def main(scenario):
    found = {}
    for case in CASES:
        Watched.commands, Watched.failed = [], []
        settings = [f"scenario:={scenario}", "odometry:=none", f"discovery_time:={case.looks}"]
        signal.alarm(PATIENCE if not case.looks else int(LONG))
        code = spin(case, ["--ros-args", *(part for item in settings for part in ("-p", item))])
        commands = Watched.commands
        found[case.__name__] = [code, *commands[-1:], len(commands), *Watched.failed]
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
