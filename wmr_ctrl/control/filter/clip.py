"""Memoryless clip of commands, which keeps the limit without odometry for any earlier commands.

A base that never overshoots keeps its limit under |u| <= (V - dbar)/K_max.  A linear loop, which
may overshoot, keeps it under |u| <= (V - delta)/N, with its peak gain N and the speed delta that
pushes alone cause (`peak_gain`).  The two axes may differ in this.  Neither bound depends on when a
command arrives: late, lost, jittering and timed-out ones are commands within the same bounds.

Commands that change by at most ``slew`` a second, a, make a linear loop overshoot less.  The
command that acts is then within a H/2 of one with that largest rate of change, where H is the
longest time that a command may act.  With the step response S, and L the integral of |1 - S| from
when S first reaches 1 on,

    |v| <= K c + a (K L + N H/2) + delta

and |u| <= c = (V - delta - a (K L + N H/2))/K is admitted (`filter.slew`).
"""

from dataclasses import replace
from functools import cached_property, reduce

import casadi as ca

from wmr_ctrl.control.sides import limits_port
from wmr_ctrl.core.signals import ASKED, LARGEST, Signal
from wmr_ctrl.world.model.system import Output, Parameters, Port, System, port
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.scenario.command_filter import FIRST_ORDER

from .channels import (
    AXES,
    DELTA,
    ELAPSED,
    FLAGS,
    LATE,
    SENT,
    TINY,
    UNSOUND,
    Channel,
    channels_of,
    ends_of,
    largest_commands,
    limited,
    punctual,
    scaled,
    sound,
    told_limits,
    two_sided,
    unusable_limits,
    usable_command,
    usable_time,
)
from .governor import admitted
from .governor_step import stated
from .peak_gain import peak_gains
from .step_response import longest_swing

LAST = Signal("v_last", "m/s, rad/s", "command that was sent last", 2)
REACH = Signal("filter.slew_reach", "s", "speed beyond a command that changes by 1 a second", 2)
PEAK_GAIN = Signal("filter.peak_gain", "1", "largest speed that commands of at most 1 lead to", 2)


UNTOLD = 0.25
"""Share of a period by which a step may be off without the flag "late": no limit hangs on it."""


class Clip:
    """Graph of a clip: its channels, their limits and the command that is sent.

    ``channels`` have the limits in force, ``widest`` those of the scenario.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Create the ports; a linear loop's peak gain is computed here and is a parameter."""
        self.scenario, self.asked, self.elapsed = scenario, port(ASKED), port(ELAPSED)
        self.p, numbers = _numbers(scenario)
        self.widest = self.channels = channels_of(scenario, self.p, numbers)
        self.told: tuple[Port, ...] = ()
        if scenario.filter.changing:
            self.told = (limits_port(scenario),)
            self.channels = _changed(two_sided(self.channels), self.told[0].sym)
        self.T = self.p.take("clock.control")
        self.limits, self.behind = _largest(scenario, self.p, self.channels)
        self.command, self.refused = usable_command(self.asked.sym)
        self.last: tuple[Port, ...] = () if scenario.filter.slew is None else (port(LAST),)
        self.sound = reduce(ca.logic_and, self._sound_ramp(), sound(self.channels))

    @cached_property
    def sent(self) -> ca.SX:
        """Command (2,) that is sent."""
        backwards, scale = [-limit for limit in self.behind], self.scenario.filter.scale
        safe = scaled(self.command, self.channels, backwards, self.limits, scale)
        return ca.if_else(self.sound, self._slowly(safe) if self.last else safe, 0)

    def _sound_ramp(self) -> list[ca.SX]:
        """Conditions under which the slew limit is usable within a period; 0 for NaN."""
        if not self.last:
            return []
        slew, reach = self.p.take("filter.slew"), self.p.take(REACH.name)
        axes = (test for i in AXES for test in (slew[i] > 0, reach[i] >= 0))
        return [*axes, self.T > 0, self.T <= LARGEST]

    @cached_property
    def time(self) -> ca.SX:
        """Time in which the command may change [s]."""
        return usable_time(self.elapsed.sym, self.T)

    def _slowly(self, wanted: ca.SX) -> ca.SX:
        """Command (2,) moved from the last one towards ``wanted``, at most at the slew rate."""
        most, last = self.p.take("filter.slew") * self.time, self.last[0].sym
        shares = ramp_shares(last, wanted, most)
        if self.scenario.filter.scale != "axes":
            shares = [reduce(ca.fmin, shares)] * len(shares)
        return ca.if_else(self.time > 0, moved(last, wanted, ca.vertcat(*shares)), last)

    @property
    def system(self) -> System:
        """The sampled System; its state is the last command sent, if that matters."""
        jitter = self.scenario.filter.jitter / self.scenario.clock.control
        came = punctual(self.elapsed.sym, self.T, max(jitter, UNTOLD))
        flags = limited(self.sent, self.command) + self.refused + ca.if_else(came, 0, LATE)
        flags += unusable_limits(self.told[0].sym) if self.told else 0
        flagged = ca.if_else(self.sound, flags, UNSOUND)
        return System(
            "filter", "command filter (clip)", inputs=(self.asked, self.elapsed, *self.told),
            params=self.p.ports, state=self.last, update=self.sent if self.last else ca.SX(0, 1),
            outputs=(Output(SENT, self.sent), Output(FLAGS, flagged)),
            period=self.scenario.clock.control,
        )  # fmt: skip


def _numbers(scenario: Scenario) -> tuple[Parameters, tuple[ca.SX, ca.SX, ca.SX]]:
    """Parameters of a clip, and its gain (least, largest of each axis) and push."""
    if scenario.filter.loop == FIRST_ORDER:
        p = Parameters(scenario)
        return p, stated(p)
    peaks = peak_gains(scenario)
    N = port(PEAK_GAIN, [item.gain for item in peaks])
    delta = port(DELTA, [item.push for item in peaks])
    if scenario.filter.slew is None:
        return Parameters(scenario, (N, delta)), (N.sym, N.sym, delta.sym)
    reach = port(REACH, slew_reach(scenario))
    p = Parameters(scenario, (delta, reach))
    least, most, _ = stated(p)
    return p, (least, most, delta.sym + p.take("filter.slew") * reach.sym)


def _largest(
    scenario: Scenario, p: Parameters, channels: list[Channel]
) -> tuple[list[ca.SX], list[ca.SX]]:
    """Largest commands that are always safe, forwards and backwards, of each channel.

    Those of overshooting loops keep the limits of both directions.
    """
    (ahead, back), loops = largest_commands(channels), scenario.filter.loop
    if loops != FIRST_ORDER and len(channels[0].sides) > 1:
        for i, (least, most) in enumerate(ends_of(p, "gain")):
            if loops[i] != "first-order":
                N = channels[i].bounds.K_max
                own, other = (b.V - b.dbar for b in channels[i].sides)
                ahead[i] = swung(N, least, most, own, other)
                back[i] = swung(N, least, most, other, own)
    return ahead, back


def swung(N: ca.SX, least: ca.SX, most: ca.SX, own: ca.SX, other: ca.SX) -> ca.SX:
    """Largest command one way that keeps the limit ``own`` this way and ``other`` the other way.

    With commands in [-b, a] the speed is at most P a + Q b, and at least -(Q a + P b), for P and Q
    the integrals of the impulse response's positive and negative part. Their sum is at most the
    peak gain N, their difference the gain, in [least, most] (`filter.peak-sides`).
    """
    gain = ca.if_else(own >= other, least, most)
    both = (other + (N + gain) * (own - other) / (least + most)) / N
    alone = ca.fmin(2 * own / (N + most), 2 * other / ca.fmax(N - least, TINY))
    return ca.fmax(0, ca.fmin(both, alone))


def _changed(channels: list[Channel], told: ca.SX) -> list[Channel]:
    """The channels with the received limits (4,)."""
    forth, back = told_limits(told, channels)
    pairs = zip(channels, zip(forth, back, strict=True), strict=True)
    return [
        replace(c, sides=tuple(replace(b, V=V) for b, V in zip(c.sides, limits, strict=True)))
        for c, limits in pairs
    ]


def ramp_shares(last: ca.SX, wanted: ca.SX, most: ca.SX) -> list[ca.SX]:
    """Share of each axis' change to ``wanted`` that a change of at most ``most`` allows."""
    return admitted(ca.vertsplit(wanted - last), ca.vertsplit(-most), ca.vertsplit(most))


def moved(last: ca.SX, wanted: ca.SX, share: ca.SX) -> ca.SX:
    """Command at a ``share`` of the way from ``last`` to ``wanted``."""
    return last + share * (wanted - last)


def slew_reach(scenario: Scenario) -> tuple[float, float]:
    """K L + N H/2 of both axes [s], rounded up, for the filter's timing of commands.

    With ``jitter``, the shortest possible period lets commands change fastest.
    """
    settings, T = scenario.filter, scenario.clock.control
    acts, quicker = (1 + settings.losses) * (T + settings.jitter), T / (T - settings.jitter)
    reach = []
    for i, peak in enumerate(peak_gains(scenario)):
        (first, last), (_, K) = settings.intervals("delay")[i], settings.intervals("gain")[i]
        H = acts + last - first
        reach.append(
            quicker * (K * longest_swing(scenario, i) + peak.gain * H / 2) * (1 + 2.0**-49)
        )
    return reach[0], reach[1]
