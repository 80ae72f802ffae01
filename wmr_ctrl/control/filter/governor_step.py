"""The governor's step as a graph, from odometry to the command that is sent.

Its state is the bounds of every channel's speed and the commands that may still act.
"""

from functools import cached_property, reduce

import casadi as ca

from wmr_ctrl.control.guard.lateness import Times
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.values import Pair
from wmr_ctrl.core.signals import ASKED, LARGEST, Signal
from wmr_ctrl.world.model.system import Output, Parameters, Port, System, port
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.scenario.command_filter import MOST_PERIODS

from .channels import (
    BOUNDS_LEFT,
    ELAPSED,
    FLAGS,
    LATE,
    SENT,
    UNSOUND,
    UNUSED,
    WAYS,
    channels_of,
    ends_of,
    gains_of,
    limited,
    scaled,
    sound,
    usable_command,
)
from .governor import (
    Schedule,
    SpeedBound,
    drive,
    drive_back,
    largest_command,
)
from .heard import Heard
from .heard import Sides as Sides

IN_TIME = Signal("in_time", "1", "samples in time since the last that was not")


AGREED = 2.0**-15
"""Share of V by which a speed's bounds from above and below may contradict each other: roundings,
also those of single precision, make less of bounds that touch (`filter.rounding.agrees`)."""
SIDES = (("v_above", "bound of the velocity"), ("v_below", "bound of the velocity's negative"))


def check_jitter(scenario: Scenario) -> None:
    """Raise ScenarioError if a sample may come as early as the one before it."""
    jitter, T = scenario.filter.jitter, scenario.clock.control
    if jitter >= T:
        raise ScenarioError(
            f"filter.jitter = {jitter:g} s must be less than the period between samples, "
            f"clock.control = {T:g} s."
        )


def schedules(scenario: Scenario) -> tuple[Schedule, Schedule]:
    """The filter's times of v and of omega in control periods.

    Raises ScenarioError if they span more samples than the filter can count.
    """
    check_jitter(scenario)
    linear, angular = (_schedule(scenario, delay) for delay in scenario.filter.intervals("delay"))
    return linear, angular


def _schedule(scenario: Scenario, delay: Pair) -> Schedule:
    settings, T = scenario.filter, scenario.clock.control
    first, last = delay
    times = first, last, settings.jitter, settings.age, settings.hold
    in_periods = (float(item) for item in map(Times(T, scenario.clock.plant).in_periods, times))
    soonest, latest, jitter, age, hold = in_periods
    plan = Schedule((soonest, latest), settings.losses, jitter, age, hold)
    span = (last + settings.age) / (T - settings.jitter) + settings.losses
    if span > MOST_PERIODS:
        raise ScenarioError(
            f"filter: delay, age of odometry and losses span {span:.0f} control periods of "
            f"{T:g} s and the governor handles at most {MOST_PERIODS}. State shorter ones, or "
            'set filter.kind = "clip", which does not depend on them.'
        )
    return plan


class Governor(Heard):
    """Graph of a governor, from odometry to the command that is sent."""

    def __init__(self, scenario: Scenario) -> None:
        """Create the ports; ScenarioError if the times span too many samples."""
        self.scenario, self.plans, self.p = scenario, schedules(scenario), Parameters(scenario)
        self.asked, self.elapsed = port(ASKED), port(ELAPSED)
        self.counted = (port(IN_TIME, self.oldest),) if self.oldest > 1 else ()
        self.T, tau = self.p.take("clock.control"), ends_of(self.p, "tau")
        loops = list(zip(self.plans, tau, strict=True))
        kappa = [1 / ca.expm1(plan.longest * self.T / least) for plan, (least, _) in loops]
        self.channels = channels_of(scenario, self.p, stated(self.p), kappa)
        owners = [loops[0] if c.ways[0] else loops[1] for c in self.channels]  # alike for wheels
        pairs = list(zip(self.channels, owners, strict=True))
        self.motions = [
            [SpeedBound(plan, c.sides[place], own, self.T) for c, (plan, own) in pairs]
            for place in (0, -1)
        ]
        self.command, self.refused = usable_command(self.asked.sym)
        apart = tau[: self.p.take("filter.tau").numel() // 2]
        times = [ca.logic_and(least > 0, most >= least) for least, most in apart]
        times += [self.T > 0, self.T <= LARGEST, *(most <= LARGEST for _, most in apart)]
        self.sound = reduce(ca.logic_and, (*times, sound(self.channels)))

    @cached_property
    def known(self) -> list[Port]:
        """State: bounds of the speed and of its negative, of all channels."""
        starts = zip(*(channel.largest for channel in self.channels), strict=True)
        pairs = zip(SIDES, starts, strict=True)
        return [port(_known(*side, len(start)), start) for side, start in pairs]

    @cached_property
    def now(self) -> Sides:
        """Bounds of the present speed: the propagated one combined with odometry."""
        sides = []
        for way, known, motions in zip(WAYS, self.known, self.motions, strict=True):
            odometry = [
                motion.now(way * channel.of(self.odometry.sym), self.age.sym, self._targets(way, i))
                for i, (motion, channel) in enumerate(zip(motions, self.channels, strict=True))
            ]
            pairs = zip(odometry, motions, strict=True)
            most = [ca.if_else(self.seen, bound, m.bounds.V) for bound, m in pairs]
            sides.append([ca.fmin(known.sym[i], bound) for i, bound in enumerate(most)])
        return sides

    @cached_property
    def agrees(self) -> ca.SX:
        """1 where odometry and the stated bounds do not contradict each other."""
        largest = (reduce(ca.fmax, [b.V for b in c.sides]) for c in self.channels)
        both = zip(*self.now, largest, strict=True)
        agree = [above + below >= -contradiction(V) for above, below, V in both]
        return reduce(ca.logic_and, agree)

    @cached_property
    def trusted(self) -> ca.SX:
        """1 if the bounds are valid; otherwise the memoryless clip is used."""
        return ca.logic_and(self.agrees, self.punctual)

    @cached_property
    def start(self) -> Sides:
        """Bounds of the present speed, V if they are not trusted."""
        return [
            [ca.if_else(self.trusted, v, m.bounds.V) for v, m in zip(side, motions, strict=True)]
            for side, motions in zip(self.now, self.motions, strict=True)
        ]

    @cached_property
    def limits(self) -> Sides:
        """Largest safe commands of all channels, forwards and backwards."""
        sides = []
        for way, side, motions in zip(WAYS, self.start, self.motions, strict=True):
            limits = []
            for i, motion in enumerate(motions):
                v_bar, b = motion.takeover(side[i], self._targets(way, i)), motion.bounds
                if motion.schedule.delay[1]:
                    v_bar = ca.if_else(self.trusted, v_bar, b.V)
                limits.append(largest_command(v_bar, b))
            sides.append(limits)
        return sides

    @property
    def within_limits(self) -> ca.SX:
        """Command (2,) within `limits`."""
        upper, lower = self.limits
        backwards, scale = [-limit for limit in lower], self.scenario.filter.scale
        return scaled(self.command, self.channels, backwards, upper, scale)

    @cached_property
    def safe(self) -> ca.SX:
        """Safe command (2,) for sound parameters."""
        return self.within_limits

    @cached_property
    def sent(self) -> ca.SX:
        """Command sent (2,): the safe one, or 0 if the parameters are unsound."""
        return ca.if_else(self.sound, self.safe, 0)

    @cached_property
    def following(self) -> Sides:
        """Bounds of the speed at the next sample, after the safe command."""
        return [
            [
                motion.following(side[i], self._targets(way, i, self.safe))
                for i, motion in enumerate(motions)
            ]
            for way, side, motions in zip(WAYS, self.start, self.motions, strict=True)
        ]

    def _targets(self, way: int, number: int, newest: ca.SX | None = None) -> list[ca.SX]:
        """Steady speed that each command can cause in a channel, by the command's age; [0]: the
        newest.
        """
        first = self.before[0].sym if newest is None else newest
        commands, channel = [first, *(item.sym for item in self.before)], self.channels[number]
        most = drive if way > 0 else drive_back
        return [most(channel.of(command), channel.bounds) for command in commands]

    @property
    def inputs(self) -> tuple[Port, ...]:
        """Inputs of each step."""
        return self.asked, self.odometry, self.age, self.elapsed

    @property
    def flags(self) -> ca.SX:
        """Sum of the flags, for sound parameters."""
        flags = limited(self.sent, self.command) + ca.if_else(self.seen, 0, UNUSED) + self.refused
        flags += ca.if_else(self.agrees, 0, BOUNDS_LEFT) + ca.if_else(self.punctual, 0, LATE)
        return flags

    @property
    def memory(self) -> tuple[tuple[Port, ...], list[ca.SX]]:
        """State and its next values: first the bounds and the commands that may still act."""
        bounds = ca.vertcat(*(item for side in self.following for item in side))
        older = [item.sym for item in self.before[:-1]]
        known = ca.if_else(self.sound, bounds, LARGEST)
        if self.counted:  # commands that were not sent in time may act at other times
            known = ca.if_else(self.punctual, known, LARGEST)
        state = (*self.known, *self.before, *self.counted)
        return state, [known, self.sent, *older, *self.in_time]

    @property
    def system(self) -> System:
        """The sampled System of the governor."""
        state, update = self.memory
        return System(
            "filter",
            "command filter (governor)",
            inputs=self.inputs,
            state=state,
            params=self.p.ports,
            update=ca.vertcat(*update),
            outputs=(
                Output(SENT, self.sent),
                Output(FLAGS, ca.if_else(self.sound, self.flags, UNSOUND)),
            ),
            period=self.scenario.clock.control,
        )


def contradiction(V: ca.SX) -> ca.SX:
    """Tolerance [m/s, rad/s] for a contradiction between two bounds of a speed."""
    return AGREED * V


def stated(p: Parameters) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Stated gains (least and largest of each axis) and stated push."""
    return *gains_of(p), p.take("filter.d")


def _known(name: str, meaning: str, size: int) -> Signal:
    return Signal(name, "m/s, rad/s", f"{meaning}, of each channel", size)
