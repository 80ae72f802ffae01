"""Clip that stops before obstacles, on a base that never overshoots its command.

The base slows down by at least A (`filter.decel`) towards K u + d, behind a delay and a lag of at
most tau, and stands B after 0 took effect.  A command u that acts for at most H, then 0, moves it
by at most

    way = (d + w) h + w^2/(2 A) + d B,  w = max(v_bar, K_max u + d) - d,  h = last delay + H + tau

with v_bar the bound of its speed by odometry and by all commands in transit.  So a command passes
if w <= A (sqrt(h^2 + 2 (free - h d - d B)/A) - h) (`filter.free.ramp`).  From standstill the base
is driven away if one release, in which it rolls by d B, ends within the free distance.
"""

from functools import cached_property, reduce

import casadi as ca

from wmr_ctrl.world.model.system import Output, Port, System, port
from wmr_ctrl.world.scenario import Scenario

from .channels import (
    AXES,
    FLAGS,
    LATE,
    NEAR_BY,
    NO_DISTANCE,
    SENT,
    UNSOUND,
    UNUSED,
    WAYS,
    ends_of,
    is_nothing,
    limited,
    scaled,
    two_sided,
    unusable_limits,
)
from .clip import Clip
from .governor import drive, drive_back, largest
from .governor_step import IN_TIME, schedules
from .heard import Sides, Watching, each_side, shifted, whole_steps
from .stopping import TRACE


def stopping_speed(room: ca.SX, h: ca.SX, A: ca.SX) -> ca.SX:
    """Largest speed w for which w h + w^2/(2 A) is within ``room``, without cancellation; h > 0."""
    twice = 2 * ca.fmax(room, 0)
    return twice / (h + ca.sqrt(h * h + twice / A))


class RampStopper(Clip, Watching):
    """Graph of the clip.  Its state: commands that may act, bounds of the speed, free distances.

    The base may still be faster than a limit in force, which bounds only commands.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Create the ports; ScenarioError if the times span too many samples."""
        super().__init__(scenario)
        settings, p = scenario.filter, self.p
        self.channels, self.plans = two_sided(self.widest), schedules(scenario)
        self.counted = (port(IN_TIME, self.oldest),)
        self.brakes = ca.SX(0) if settings.rest is None else p.take("filter.rest")
        self.rest = self.brakes
        self.decel, self.nearing = p.take("filter.decel"), p.take("filter.nearing")
        lags = [most for _, most in ends_of(p, "tau")] if settings.tau else [ca.SX(0)] * 2
        self.reaction = [
            (plan.delay[1] + plan.acting) * self.T + lag
            for plan, lag in zip(self.plans, lags, strict=True)
        ]
        numbers = (self.decel[0] > 0, self.decel[1] > 0, self.brakes >= 0, self.nearing >= 0,
                   p.take("filter.free_error") >= 0, self.T > 0)  # fmt: skip
        self.sound = reduce(ca.logic_and, numbers, self.sound)

    def _targets(self, place: int, axis: int) -> list[ca.SX]:
        """Steady speed that each command that may act can cause, the last one first."""
        pairs = zip(self.held_before, self.before, strict=True)
        driven = [ca.if_else(h.sym, 0, self._target(place, axis, u.sym)) for h, u in pairs]
        return [*driven, *self._stopped(place, axis)]

    def _stopped(self, place: int, axis: int) -> list[ca.SX]:
        """Steady speed of a base that stops on its own, if it may."""
        b = self.channels[axis].sides[place]
        return [b.dbar] if self.plans[axis].stops_alone else []

    def _target(self, place: int, axis: int, command: ca.SX) -> ca.SX:
        return (drive, drive_back)[place](command[axis], self.channels[axis].sides[place])

    @cached_property
    def fastest(self) -> Sides:
        """v_bar: bound of the speed from now on while no new command acts."""
        return each_side(self._fastest)

    def _fastest(self, place: int, axis: int) -> ca.SX:
        b, known = self.channels[axis].sides[place], self.most_before[0].sym[2 * place + axis]
        seen = ca.if_else(self.seen, WAYS[place] * self.odometry.sym[axis] + b.nbar, b.V)
        bound = ca.fmin(known, largest([seen, *self._targets(place, axis)]))
        return ca.if_else(self.punctual, ca.fmin(bound, b.V), b.V)

    def far(self, place: int, axis: int) -> ca.SX:
        """Free distance from which on no command is limited."""
        V, age = self.channels[axis].sides[place].V, self.p.take("filter.free_age")
        stop = V * self.reaction[axis] + V * V / (2 * self.decel[axis]) + self._kept(axis)
        return 2 * (stop + V * (age + self.T) + self.p.take("filter.free_error"))

    def _kept(self, axis: int) -> ca.SX:
        """Part of the free distance that any stop needs, including releases and approaching
        obstacles.
        """
        return (1 + self.scenario.filter.leave) * self._roll(axis) + self._nears(axis)

    def _roll(self, axis: int) -> ca.SX:
        return self.channels[axis].bounds.dbar * self.brakes

    def _nears(self, axis: int) -> ca.SX:
        """Distance that an obstacle approaches until the base stands."""
        if axis:
            return ca.SX(0)
        return self.nearing * (self._slows(0) + self.brakes)

    def _slows(self, axis: int) -> ca.SX:
        """Longest time [s] until the base has slowed down from either limit."""
        fastest = largest([b.V for b in self.channels[axis].sides])
        return self.reaction[axis] + fastest / self.decel[axis]

    @cached_property
    def stopping(self) -> Sides:
        """Largest commands by the free distances; below 0 if no stop ends in time."""
        return each_side(self._stopping)

    def _stopping(self, place: int, axis: int) -> ca.SX:
        b, h = self.channels[axis].sides[place], self.reaction[axis]
        room = self.free_now[place][axis] - self._kept(axis) - b.dbar * h
        most = stopping_speed(room, h, self.decel[axis])
        slow = self.fastest[place][axis] - b.dbar <= most
        return ca.if_else(ca.logic_and(room >= 0, slow), most / b.K_max, -1)

    @cached_property
    def offered(self) -> ca.SX:
        """Command (2,) before it is known whether the brake may open for it."""
        pairs = zip((self.limits, self.behind), self.stopping, strict=True)
        upper, lower = ([ca.fmax(0, m) for m in map(ca.fmin, *pair)] for pair in pairs)
        back = [-limit for limit in lower]
        sent = scaled(self.command, self.channels, back, upper, self.scenario.filter.scale)
        return ca.if_else(ca.fabs(sent) > TRACE, sent, 0)

    @cached_property
    def opens(self) -> ca.SX:
        """1 if no side forbids the command."""
        return reduce(ca.logic_and, (item for side in each_side(self._is_open) for item in side))

    def _is_open(self, place: int, axis: int) -> ca.SX:
        b, way = self.channels[axis].sides[place], WAYS[place]
        u, enough = way * self.offered[axis], self._roll(axis) + self._nears(axis)
        away = ca.logic_and(u < 0, b.K_min * u + b.dbar <= 0)
        stands = self.held_before[0].sym
        leaves = [ca.logic_and(stands, self.free_now[place][axis] >= enough)]
        if not self.scenario.filter.nearing:  # else only zeros let it stand in time
            went = way * self.before[0].sym[axis] < 0
            leaves += [b.dbar == 0, ca.logic_and(went, self.fastest[place][axis] <= 0)]
        passes = ca.logic_and(away, reduce(ca.logic_or, leaves))
        return ca.logic_or(self.stopping[place][axis] >= 0, passes)

    @cached_property
    def safe(self) -> ca.SX:
        """Safe command (2,)."""
        return ca.if_else(ca.logic_and(self.opens, self.sound), self.offered, 0)

    @cached_property
    def held(self) -> ca.SX:
        """1 if the base stands by the time the command acts, and (0, 0) is sent."""
        if self.scenario.filter.rest is None:  # a lag alone never ends
            return ca.SX(0)
        slowest = largest([self._slows(axis) for axis in AXES])
        enough = whole_steps(self.plans[0], self.T, self.brakes + slowest)
        return ca.logic_and(is_nothing(self.safe), self.in_row >= enough)

    @cached_property
    def most(self) -> Sides:
        """Bound of the speed while the command just sent acts."""
        return each_side(self._most)

    def _most(self, place: int, axis: int) -> ca.SX:
        target = self._target(place, axis, self.safe)
        stopped = self._stopped(place, axis)
        bound = largest([ca.SX(0), self.fastest[place][axis], target, *stopped])
        return ca.if_else(self.held, 0, bound)

    @cached_property
    def free_following(self) -> list[ca.SX]:
        """Free distances at the next sample."""
        return [self._free_following(place, i) for i in AXES for place in AXES]

    def _free_following(self, place: int, axis: int) -> ca.SX:
        latest = (1 + self.plans[axis].jitter) * self.T
        speed = self.most[place][axis] + (0 if axis else self.nearing)
        gone = speed * latest + self.off(place, axis, latest)
        return self.free_now[place][axis] - gone

    @property
    def system(self) -> System:
        """The sampled System; its state is the commands that may act, and the free distances."""
        flags = limited(self.safe, self.command) + self.refused
        flags += ca.if_else(self.seen, 0, UNUSED) + ca.if_else(self.punctual, 0, LATE)
        flags += ca.if_else(self.opens, 0, NEAR_BY) + ca.if_else(self.is_fresh, 0, NO_DISTANCE)
        flags += unusable_limits(self.told[0].sym) if self.told else 0
        state: list[Port] = [*self.before, *self.counted]
        update = [self.safe, *shifted(self.before), *self.in_time]
        for ports, new, _ in self.watched:
            state += ports
            update += new
        inputs = (self.asked, self.odometry, self.age, self.elapsed)
        flagged = ca.if_else(self.sound, flags, UNSOUND)
        return System(
            "filter", "command filter (clip that stops)",
            inputs=(*inputs, *self.told, self.free, self.free_age), state=tuple(state),
            params=self.p.ports, update=ca.vertcat(*update),
            outputs=(Output(SENT, self.safe), Output(FLAGS, flagged)),
            period=self.scenario.clock.control,
        )  # fmt: skip
