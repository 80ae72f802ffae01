"""Memoryless clip of commands: what keeps the limit without odometry, whatever came before.

A base that never overshoots is kept by |u| <= (V - dbar)/K_max; a linear loop, which may, by |u| <=
(V - delta)/N with its peak gain N and what pushes alone lead to, delta (`peak_gain`).  Neither
asks when a command arrives: late, lost, jittering and timed-out ones are commands within the same
bounds.
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.filter.channels import (
    DELTA,
    FLAGS,
    SENT,
    UNSOUND,
    Channel,
    channels_of,
    limited,
    scaled,
    sound,
    usable_command,
)
from wmr_ctrl.filter.governor import largest_command
from wmr_ctrl.filter.governor_step import stated
from wmr_ctrl.filter.peak_gain import peak_gains
from wmr_ctrl.model.system import Output, Parameters, System, port
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import ASKED, Signal

PEAK_GAIN = Signal("filter.peak_gain", "1", "largest speed that commands of at most 1 lead to", 2)


class Clip:
    """The graph of a clip: its channels, their limits and the command that is sent."""

    def __init__(self, scenario: Scenario) -> None:
        """Take the ports; the peak gain of a linear loop is computed here, and is a parameter."""
        self.scenario, self.asked = scenario, port(ASKED)
        if scenario.filter.loop == "first-order":
            self.p = Parameters(scenario)
            numbers = stated(self.p)
        else:
            peaks = peak_gains(scenario)
            N = port(PEAK_GAIN, [item.gain for item in peaks])
            delta = port(DELTA, [item.push for item in peaks])
            self.p = Parameters(scenario, (N, delta))
            numbers = N.sym, N.sym, delta.sym
        self.channels: list[Channel] = channels_of(scenario, self.p, numbers, ca.SX(0))
        self.limits = [largest_command(c.bounds.V, c.bounds) for c in self.channels]
        self.command, self.refused = usable_command(self.asked.sym)
        self.sound = sound(self.channels)
        backwards = [-limit for limit in self.limits]
        safe = scaled(self.command, self.channels, backwards, self.limits, scenario.filter.scale)
        self.sent = ca.if_else(self.sound, safe, 0)

    @property
    def system(self) -> System:
        """The sampled System, which has no state."""
        flags = limited(self.sent, self.command) + self.refused
        flagged = ca.if_else(self.sound, flags, UNSOUND)
        return System(
            "filter", "command filter (clip)", inputs=(self.asked,), params=self.p.ports,
            outputs=(Output(SENT, self.sent), Output(FLAGS, flagged)),
            period=self.scenario.clock.control,
        )  # fmt: skip
