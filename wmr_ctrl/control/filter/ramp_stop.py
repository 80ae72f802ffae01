"""Clip that stops before what is in the way, on a base that never passes its command.

The base slows down by at least A (`filter.decel`) towards a smaller command, behind a delay and a
lag of at most tau.  A command u that acts for at most H, then 0, takes it no farther than

    way = m h + m^2/(2 A) + d B,        m = max(v_bar, K_max u + d),  h = last delay + H + tau

with v_bar the bound of its speed by odometry and by all commands under way, so that a command
passes where m <= A (sqrt(h^2 + 2 (free - d B)/A) - h) (`filter.free.ramp`).  From standstill it is
driven away where one release, which rolls d B, ends within the free way.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, reduce

import casadi as ca

from wmr_ctrl.core.signals import LARGEST, ODOMETRY_AGE
from wmr_ctrl.world.model.system import Output, Port, System, port
from wmr_ctrl.world.scenario import Scenario

from .channels import (
    AXES,
    FLAGS,
    FREE,
    FREE_AGE,
    LATE,
    NEAR_BY,
    NO_DISTANCE,
    ROUNDING,
    SENT,
    UNSOUND,
    UNUSED,
    WAYS,
    ends_of,
    is_nothing,
    largest_commands,
    limited,
    scaled,
    two_sided,
    unusable_limits,
)
from .clip import Clip
from .governor import drive, drive_back, largest
from .governor_step import IN_TIME, ODOMETRY, Sides, schedules, sent_signal
from .heard import Watching
from .stopping import FREE_KNOWN, RESTED, TRACE, held_signal, most_signal, whole_steps


def stopping_speed(room: ca.SX, h: ca.SX, A: ca.SX) -> ca.SX:
    """Largest speed m for which m h + m^2/(2 A) is within ``room``."""
    return A * (ca.sqrt(h * h + 2 * ca.fmax(room, 0) / A) - h)


class RampStopper(Clip, Watching):
    """Graph of the clip; its state is what may act, what that allows, and the free ways."""

    def __init__(self, scenario: Scenario) -> None:
        """Create the ports; ScenarioError if the times span too many samples."""
        super().__init__(scenario)
        settings, p = scenario.filter, self.p
        self.channels = two_sided(self.channels)
        self.plans = schedules(scenario)
        young = settings.free_age / scenario.clock.control
        aged = (replace(plan, age=max(plan.age, young)) for plan in self.plans)
        self.oldest = max(plan.oldest for plan in aged)
        ages = range(1, self.oldest + 1)
        self.odometry, self.age = port(ODOMETRY), port(ODOMETRY_AGE, -1.0)
        self.counted = (port(IN_TIME, self.oldest),)
        self.free, self.free_age = port(FREE, [LARGEST] * 4), port(FREE_AGE, -1.0)
        self.before = [port(sent_signal(age)) for age in ages]
        starts = [c.largest[place] for place in (0, -1) for c in self.channels]
        self.most_before = [port(most_signal(age), starts) for age in ages]
        self.held_before, self.rested = [port(held_signal(age)) for age in ages], port(RESTED)
        self.free_known = port(FREE_KNOWN, [-1.0] * 4)
        self.decel, self.error = p.take("filter.decel"), p.take("filter.free_error")
        self.nearing = p.take("filter.nearing")
        self.rest = ca.SX(0) if settings.rest is None else p.take("filter.rest")
        lags = [most for _, most in ends_of(p, "tau")] if settings.tau else [ca.SX(0)] * 2
        self.reaction = [
            (plan.delay[1] + plan.acting) * self.T + lag
            for plan, lag in zip(self.plans, lags, strict=True)
        ]
        numbers = (self.decel[0] > 0, self.decel[1] > 0, self.rest >= 0, self.nearing >= 0,
                   self.error >= 0, self.T > 0)  # fmt: skip
        self.sound = reduce(ca.logic_and, numbers, self.sound)

    def _targets(self, place: int, axis: int, newest: ca.SX | None = None) -> list[ca.SX]:
        """Steady speed to which each command may drive: [0] the newest, if it is given."""
        b, most = self.channels[axis].sides[place], (drive, drive_back)[place]
        held = [h.sym for h in self.held_before]
        old = [most(item.sym[axis], b) for item in self.before]
        targets = [ca.if_else(h, 0, target) for h, target in zip(held, old, strict=True)]
        return targets if newest is None else [most(newest[axis], b), *targets]

    @cached_property
    def fastest(self) -> Sides:
        """v_bar: bound of the speed from now on while no new command acts."""
        sides = []
        for place, way in enumerate(WAYS):
            speeds = []
            for i, channel in enumerate(self.channels):
                b = channel.sides[place]
                seen = way * self.odometry.sym[i] + b.nbar
                stands = self.held_before[0].sym
                known = ca.if_else(stands, 0, ca.if_else(self.seen, seen, b.V))
                bound = largest([known, *self._targets(place, i)])
                speeds.append(ca.if_else(self.punctual, ca.fmin(bound, b.V), b.V))
            sides.append(speeds)
        return sides

    @cached_property
    def free_now(self) -> Sides:
        """Free way of each side: told, or what was told before less the way since then."""
        sides = []
        for place in AXES:
            ways = []
            for i, channel in enumerate(self.channels):
                before = [item.sym[2 * place + i] for item in self.most_before]
                most = ca.if_else(self.punctual, largest(before), channel.sides[place].V)
                error, nearing = (ca.SX(0), ca.SX(0)) if i else (self.error, self.nearing)
                far = self._far(place, i)
                told = ca.fmin(self.free.sym[place + 2 * i], far) - error - ROUNDING * far
                told -= (ca.fmax(most, 0) + nearing) * self.free_age.sym
                known = ca.if_else(self.came, self.free_known.sym[place + 2 * i], -1)
                ways.append(ca.if_else(self.hears(place + 2 * i), told, known))
            sides.append(ways)
        return sides

    def _far(self, place: int, axis: int) -> ca.SX:
        """Way from which on a free way limits no command."""
        V = self.channels[axis].sides[place].V
        return (
            2 * (self._stop(axis, V) + V * (self.p.take("filter.free_age") + self.T)) + self.error
        )

    def _stop(self, axis: int, m: ca.SX) -> ca.SX:
        """Way of a stop from the speed m."""
        own = m * self.reaction[axis] + m * m / (2 * self.decel[axis])
        return own + (1 + self.scenario.filter.leave) * self._roll(axis) + self._nears(axis)

    def _roll(self, axis: int) -> ca.SX:
        return self.channels[axis].bounds.dbar * self.rest

    def _nears(self, axis: int) -> ca.SX:
        """Way that what is in the way comes nearer until the base stands."""
        if axis:
            return ca.SX(0)
        slowing = self.channels[0].bounds.V / self.decel[0]
        return self.nearing * (self.reaction[0] + slowing + self.rest)

    @cached_property
    def stopping(self) -> Sides:
        """Largest commands by the free ways; below 0 where no stop ends in time."""
        sides = []
        for place in AXES:
            limits = []
            for i, channel in enumerate(self.channels):
                b, h, A = channel.sides[place], self.reaction[i], self.decel[i]
                least = self._stop(i, ca.SX(0))
                room = self.free_now[place][i] - least
                root = stopping_speed(room, h, A)
                slow = ca.fmax(self.fastest[place][i], b.dbar) <= root
                slow = ca.logic_and(room >= 0, slow)
                limits.append(ca.if_else(slow, (root - b.dbar) / b.K_max, -1))
            sides.append(limits)
        return sides

    @cached_property
    def offered(self) -> ca.SX:
        """The command (2,) before it is known whether the brake may open for it."""
        clip = largest_commands(self.channels)
        pairs = zip(clip, self.stopping, strict=True)
        upper, lower = ([ca.fmax(0, m) for m in map(ca.fmin, *pair)] for pair in pairs)
        back, scale = [-limit for limit in lower], self.scenario.filter.scale
        sent = scaled(self.command, self.channels, back, upper, scale)
        return ca.if_else(ca.fabs(sent) > TRACE, sent, 0)

    @cached_property
    def opens(self) -> ca.SX:
        """1 where no side forbids the command."""
        opens = []
        for place, way in enumerate(WAYS):
            for i, channel in enumerate(self.channels):
                b, u = channel.sides[place], way * self.offered[i]
                away = ca.logic_and(u < 0, b.K_min * u + b.dbar <= 0)
                enough = self.free_now[place][i] >= self._roll(i) + self._nears(i)
                stands = ca.logic_and(self.held_before[0].sym, enough)
                goes_on = ca.SX(0) if self.scenario.filter.nearing else self._goes_on(way, i)
                leaves = reduce(ca.logic_or, (stands, goes_on, b.dbar == 0))
                opens.append(ca.logic_or(self.stopping[place][i] >= 0, ca.logic_and(away, leaves)))
        return reduce(ca.logic_and, opens)

    def _goes_on(self, way: int, axis: int) -> ca.SX:
        return way * self.before[0].sym[axis] < 0

    @cached_property
    def safe(self) -> ca.SX:
        """The safe command (2,)."""
        return ca.if_else(ca.logic_and(self.opens, self.sound), self.offered, 0)

    @cached_property
    def held(self) -> ca.SX:
        """1 where the base stands by the time the command acts, and (0, 0) is sent."""
        plan = self.plans[0]
        slowing = [
            c.bounds.V / self.decel[i] + self.reaction[i] for i, c in enumerate(self.channels)
        ]
        time = self.rest + largest(slowing)
        return ca.logic_and(is_nothing(self.safe), self._in_row >= whole_steps(plan, self.T, time))

    @property
    def _in_row(self) -> ca.SX:
        return ca.if_else(self.came, self.rested.sym, 0)

    @cached_property
    def most(self) -> list[ca.SX]:
        """Bounds of v, omega and of their negatives while the command just sent acts."""
        most = []
        for place in AXES:
            for i in AXES:
                target, *_ = self._targets(place, i, self.safe)
                bound = ca.fmax(0, ca.fmax(self.fastest[place][i], target))
                most.append(ca.if_else(self.held, 0, bound))
        return most

    @cached_property
    def free_following(self) -> list[ca.SX]:
        """Free ways at the next sample."""
        free = []
        for i in AXES:
            latest = (1 + self.plans[i].jitter) * self.T
            for place in AXES:
                gone = self.most[2 * place + i] + (0 if i else self.nearing)
                free.append(self.free_now[place][i] - gone * latest)
        return free

    @property
    def system(self) -> System:
        """The sampled System; its state is what may act, and the free ways."""
        flags = limited(self.safe, self.command) + self.refused
        flags += ca.if_else(self.seen, 0, UNUSED) + ca.if_else(self.punctual, 0, LATE)
        flags += ca.if_else(self.opens, 0, NEAR_BY) + ca.if_else(self.is_fresh, 0, NO_DISTANCE)
        flags += unusable_limits(self.told[0].sym) if self.told else 0
        still = ca.if_else(is_nothing(self.safe), self._in_row + 1, 0)
        own: list[tuple[Sequence[Port], Sequence[ca.SX]]] = [
            (self.before, [self.safe]), (self.most_before, [ca.vertcat(*self.most)]),
            (self.held_before, [self.held]), ([self.rested], [still]),
            ([self.free_known], [ca.vertcat(*self.free_following)]),
            (self.counted, self.in_time),
        ]  # fmt: skip
        ports = [item for items, _ in own for item in items]
        update = [
            value
            for items, new in own
            for value in [*new, *(item.sym for item in items[: len(items) - len(new)])]
        ]
        return System(
            "filter", "command filter (clip that stops)",
            inputs=(
                self.asked, self.odometry, self.age, self.elapsed, *self.told, self.free,
                self.free_age,
            ),
            state=tuple(ports), params=self.p.ports, update=ca.vertcat(*update),
            outputs=(
                Output(SENT, self.safe),
                Output(FLAGS, ca.if_else(self.sound, flags, UNSOUND)),
            ),
            period=self.scenario.clock.control,
        )  # fmt: skip
