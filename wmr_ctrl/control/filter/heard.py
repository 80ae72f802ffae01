"""Inputs of a filter and whether they came in time: odometry, samples and free distances."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property, reduce
from itertools import chain
from typing import TypeAlias, TypeVar

import casadi as ca

from wmr_ctrl.control.sides import is_number
from wmr_ctrl.core.signals import LARGEST, ODOMETRY_AGE, Signal
from wmr_ctrl.world.model.system import Number, Parameters, Port, port
from wmr_ctrl.world.scenario import Scenario

from .channels import AXES, FREE, FREE_AGE, ROUNDING, Channel, is_nothing, punctual, within
from .governor import NEAR, Schedule, largest

Sides: TypeAlias = list[list[ca.SX]]
"""A number of every channel, of its speed first, then of the speed's negative."""
Made = TypeVar("Made")
ODOMETRY = Signal("v_odometry", "m/s, rad/s", "velocity from odometry", 2)
FREE_KNOWN = Signal("free_known", "m, m, rad, rad", "free distances that certainly remain", 4)
RESTED = Signal("rested", "1", "commands of (0, 0) in a row, in time")


class Heard:
    """Base class of filters with memory: recent odometry, punctual samples, punctual commands.

    ``plans``: times of v and of omega; ``counted``: the state `in_time`, if
    more than one command may act.
    """

    scenario: Scenario
    p: Parameters
    plans: tuple[Schedule, Schedule]
    T: ca.SX
    elapsed: Port
    counted: tuple[Port, ...]

    @cached_property
    def odometry(self) -> Port:
        """Input: velocity from odometry."""
        return port(ODOMETRY)

    @cached_property
    def age(self) -> Port:
        """Input: age of the odometry."""
        return port(ODOMETRY_AGE, -1.0)

    @property
    def oldest(self) -> int:
        """Number of commands that the state holds."""
        return max(plan.oldest for plan in self.plans)

    @cached_property
    def before(self) -> list[Port]:
        """State: the commands sent, the last one first."""
        return [port(_sent(age)) for age in range(1, self.oldest + 1)]

    @cached_property
    def seen(self) -> ca.SX:
        """1 if there is odometry that is recent enough and a number."""
        if self.scenario.filter.odometry is None:
            return ca.SX(0)
        age = 0.5 * self.plans[0].age * self.T
        young = within(self.age.sym - age, age + NEAR * self.T)
        return reduce(ca.logic_and, [young, *(within(self.odometry.sym[i], LARGEST) for i in AXES)])

    @cached_property
    def came(self) -> ca.SX:
        """1 if the sample came within its jitter."""
        return punctual(self.elapsed.sym, self.T, self.plans[0].jitter)

    @cached_property
    def in_time(self) -> list[ca.SX]:
        """Number of punctual samples since the last late one; empty if only one command may act."""
        most = self.oldest
        return [ca.if_else(self.came, ca.fmin(n.sym + 1, most), 0) for n in self.counted]

    @cached_property
    def punctual(self) -> ca.SX:
        """1 if all commands that may still act were sent on time."""
        return self.in_time[0] >= self.oldest if self.counted else self.came


class Watching(Heard):
    """Base class of filters that receive free distances and bound the speed under each command.

    Lists are by age of the command, the last one first.  ``rest``: time after which commands (0, 0)
    make the base stand, None if nothing does.
    """

    channels: list[Channel]
    rest: ca.SX | None

    @property
    def oldest(self) -> int:
        """Number of commands in the state, including those that acted when a distance was
        measured.
        """
        return remembered(self.plans, self.scenario)

    @cached_property
    def most_before(self) -> list[Port]:
        """State: bounds of the speed while each command acts."""
        starts = [  # less the margin for rounding, as limits are
            max(0.0, c.largest[place] - ROUNDING * max(c.largest))
            for place in (0, -1) for c in self.channels
        ]  # fmt: skip
        return [port(_most(age), starts) for age in range(1, self.oldest + 1)]

    @cached_property
    def held_before(self) -> list[Port]:
        """State: 1 if the base stands by the time each command acts; empty without ``rest``."""
        ages = range(1, self.oldest + 1) if self.rest is not None else ()
        return [port(_held(age)) for age in ages]

    @cached_property
    def rested(self) -> Port:
        """State: number of consecutive commands (0, 0)."""
        return port(RESTED)

    @cached_property
    def free_known(self) -> Port:
        """State: free distances that certainly remain."""
        return port(FREE_KNOWN, [-1.0] * 4)

    @cached_property
    def free(self) -> Port:
        """Input: free distances."""
        return port(FREE, [LARGEST] * 4)

    @cached_property
    def free_age(self) -> Port:
        """Input: age of the free distances."""
        return port(FREE_AGE, -1.0)

    @property
    def believed(self) -> ca.SX:
        """1 if the bounds of the speed under each command are valid."""
        return self.punctual

    @cached_property
    def safe(self) -> ca.SX:
        """Command (2,) that is sent."""
        raise NotImplementedError

    @cached_property
    def held(self) -> ca.SX:
        """1 if the base stands by the time the command acts, and (0, 0) is sent."""
        raise NotImplementedError

    @cached_property
    def most(self) -> Sides:
        """Bound of the speed while the command just sent acts."""
        raise NotImplementedError

    @cached_property
    def free_following(self) -> list[ca.SX]:
        """Free distances at the next sample."""
        raise NotImplementedError

    def far(self, place: int, axis: int) -> ca.SX:
        """Free distance from which on no command is limited."""
        raise NotImplementedError

    def off(self, place: int, axis: int, time: ca.SX) -> ca.SX:
        """Largest rounding error [m, rad] of a distance that is computed for a ``time`` [s]."""
        V = self.channels[axis].sides[place].V
        return ROUNDING * (V * time + 4 * ROUNDING * self.far(place, axis))

    @cached_property
    def is_fresh(self) -> ca.SX:
        """1 if free distances are received and recent enough."""
        half = 0.5 * self.p.take("filter.free_age")
        return within(self.free_age.sym - half, half + NEAR * self.T)

    def hears(self, number: int) -> ca.SX:
        """1 if this one of the free distances is fresh."""
        return ca.logic_and(self.is_fresh, is_number(self.free.sym[number]))

    @cached_property
    def free_now(self) -> Sides:
        """Free distance on each side: the received one, or the last one less the distance driven
        since.
        """
        return each_side(lambda place, i: self._free(place, i, self.far(place, i)))

    @cached_property
    def free_whole(self) -> Sides:
        """Free distance on each side, without the cap at `far`."""
        return each_side(lambda place, i: self._free(
            place, i, ca.fmax(self.far(place, i), ca.fmin(self.free.sym[place + 2 * i], LARGEST))
        ))  # fmt: skip

    def _free(self, place: int, axis: int, far: ca.SX) -> ca.SX:
        number, V = place + 2 * axis, self.channels[axis].sides[place].V
        most = largest([ca.SX(0), *(item.sym[2 * place + axis] for item in self.most_before)])
        speed = ca.if_else(self.believed, most, V)
        told = ca.fmax(ca.fmin(self.free.sym[number], far), -LARGEST)
        if axis == 0:
            speed += self.p.take("filter.nearing")
            told -= self.p.take("filter.free_error")
        told = told - speed * self.free_age.sym - ROUNDING * far
        known = ca.if_else(self.came, self.free_known.sym[number], -1)
        return ca.if_else(self.hears(number), told, known)

    @property
    def in_row(self) -> ca.SX:
        """Number of consecutive punctual commands (0, 0) before this one."""
        return ca.if_else(self.came, self.rested.sym, 0)

    @property
    def watched(self) -> list[tuple[Sequence[Port], list[ca.SX], float]]:
        """State, its next values, and its next values for unsound parameters."""
        kept: list[tuple[Sequence[Port], list[ca.SX], float]] = [
            (self.most_before, [*chain(*self.most), *shifted(self.most_before)], LARGEST)
        ]
        if self.rest is not None:
            still = ca.if_else(is_nothing(self.safe), self.in_row + 1, 0)
            kept.append((self.held_before, [self.held, *shifted(self.held_before)], 0))
            kept.append(([self.rested], [still], 0))
        if self.scenario.filter.free_error is not None:
            kept.append(([self.free_known], self.free_following, -1))
        return kept


def each_side(make: Callable[[int, int], Made]) -> list[list[Made]]:
    """Results of ``make`` for each direction, forwards and backwards, of each axis."""
    return [[make(place, axis) for axis in AXES] for place in AXES]


def shifted(before: Sequence[Port]) -> list[ca.SX]:
    """All elements except the oldest."""
    return [item.sym for item in before[:-1]]


def remembered(plans: Iterable[Schedule], scenario: Scenario) -> int:
    """Number of commands that may act between a distance's measurement and the sample, or later.

    With a brake, also one that ends at the sample.
    """
    settings = scenario.filter
    age = settings.free_age / scenario.clock.control if settings.free_error is not None else 0.0
    age = age if settings.rest is None else max(age, 2 * NEAR)
    oldest = (replace(plan, age=max(plan.age, age)).oldest for plan in plans)
    return max(1 + settings.losses, *oldest)


def whole_steps(plan: Schedule, T: Number, time: Number, more: float = -NEAR) -> Number:
    """Number of commands that surely act for at least this ``time`` [s], plus ``more`` of a period.

    A brake ends a motion instantly, so rest needs more than the time after which it closes.
    """
    return ca.ceil((time + plan.spread * T) / ((1 - plan.jitter) * T) + more)


def _sent(age: int) -> Signal:
    return Signal(f"v_sent_{age}", "m/s, rad/s", f"command sent {age} samples ago", 2)


def _most(age: int) -> Signal:
    said = f"bound of v, omega and of their negatives while the command of {age} samples ago acts"
    return Signal(f"v_most_{age}", "m/s, rad/s, m/s, rad/s", said, 4)


def _held(age: int) -> Signal:
    return Signal(f"held_{age}", "1", f"1: the base stands while the command of {age} ago acts")
