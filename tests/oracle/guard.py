"""The velocity guard and the maps behind it, one axis after the other; and the monitor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

_SHRINK = 2.0**-44


@dataclass(frozen=True, slots=True)
class GuardedAxis:
    """One axis: limit, masses, bounds of disturbance and measurement, friction floor; and times.

    ``aim`` is the limit less a margin for rounding, which grows with the number of commands in
    transit.
    """

    u1: float
    M_min: float
    M_max: float
    dbar: float
    nbar: float
    f_min: float
    f_speed: float
    aim: float
    alpha: float
    T: float
    delay: float

    @property
    def push(self):
        """Largest disturbance that friction does not compensate."""
        return self.dbar - self.f_min

    def ceiling(self, y, brake, coming):
        """Largest safe force at the measured velocity ``y`` with a coming rise of the velocity.

        Every force must leave room for another one that takes ``delay`` to act.
        """
        room = self.aim - max(y + self.nbar, self.f_speed) - coming
        gain = self.M_min * self.alpha if room >= 0.0 else self.M_max / self.T
        hi = max(gain * room - self.push, -brake)
        if self.delay == 0.0:
            return hi
        room = self.aim - self.f_speed
        room -= max(brake + self.push, 0.0) / (self.M_min * self.alpha)
        return min(hi, self.M_min * room / self.delay - self.push)

    def cap(self):
        """The largest braking force that leaves room for an equally large late force."""
        room = self.aim - self.f_speed
        return self.M_min * self.alpha * room / (1.0 + self.alpha * self.delay) - self.push

    def rise(self, force, time):
        """Largest rise of v while ``force`` acts for ``time``."""
        return max(force + self.push, 0.0) * time / self.M_min

    def can_be_kept(self, brake):
        """True if the numbers are valid and braking outweighs the push where necessary."""
        sound = self.M_min <= self.M_max and self.f_speed < self.u1 and self.alpha * self.T <= 1.0
        seen = 2.0 * self.nbar <= self.aim
        return sound and seen and self.cap() >= self.push and brake >= self.push

    def least_push(self, old, new, force):
        """Smallest disturbance that explains the step from ``old`` to ``new`` under ``force``."""
        if max(old, new) < -self.nbar:
            return self.least_push(-old, -new, -force)
        if min(old, new) <= self.nbar:
            return 0.0
        rate = (new - old - 2.0 * self.nbar) / self.T
        return max(0.0, min(self.M_min * rate, self.M_max * rate) - force)


class VelocityGuard:
    """Guard that clips a force to its safe range, and monitors whether the motion fits the bounds.

    An unguarded run also has one, which only monitors.
    """

    def __init__(self, scenario, tau_max):
        self.robot, self.settings = scenario.robot, scenario.guard
        delay, lag, T = scenario.actuator.delay, scenario.actuator.lag, scenario.clock.control
        self.times = times_that_count(delay, lag, T)
        self.sent = [(0.0, 0.0)] * len(self.times)
        self.axes = axes_of(scenario)
        self.phi = 2.0 * tau_max / scenario.robot.r
        self.brakes = self._brakes()
        within_reach = self.brakes[0] + self.brakes[1] / self.robot.l <= self.phi
        pairs = zip(self.axes, self.brakes, strict=True)
        self.feasible = float(within_reach and all(a.can_be_kept(b) for a, b in pairs))
        self.v_before = None
        self.watch(None, (0.0, 0.0))

    def _brakes(self):
        first, second = (axis.cap() for axis in self.axes)
        given, half = self.settings.brake, self.robot.l
        if given is not None:
            return min(first, given[0]), min(second, given[1])
        if math.isinf(self.phi):
            return first, second
        need = [max(axis.push, 0.0) for axis in self.axes]
        spare = max(self.phi * (1.0 - _SHRINK) - need[0] - need[1] / half, 0.0)
        share = self.settings.brake_share
        return (
            min(first, need[0] + share * spare),
            min(second, need[1] + (1.0 - share) * spare * half),
        )

    def box(self, v):
        """(lo, hi) of both axes, each a pair (thrust [N], moment [N m])."""
        return tuple(tuple(way * self._most(i, v, way) for i in (0, 1)) for way in (-1.0, 1.0))

    def _most(self, i, v, way):
        """Largest force of axis ``i`` that is safe in direction ``way``."""
        axis, pairs = self.axes[i], zip(self.times, self.sent, strict=True)
        coming = sum(axis.rise(way * force[i], time) for time, force in pairs)
        return axis.ceiling(way * v[i], self.brakes[i], coming)

    def act(self, asked, v, applied):
        """The force that may act, within the wheels' reach."""
        box = self.box(v)
        held, safe = within(asked, box), within((0.0, 0.0), box)
        changed = (float(held[0] != asked[0]), float(held[1] != asked[1]))
        self.watch(v, applied, changed)
        reach = linear_first if self.settings.map == "linear-first" else rotation_first
        force = reach(held, safe, self.phi, self.robot.l)
        self.sent = [force, *self.sent][: len(self.sent)]
        return force

    def watch(self, v, applied, changed=(0.0, 0.0)):
        """Record the sample at velocity ``v`` after the ``applied`` torque."""
        least = self._least(v, applied)
        self.seen = {"clip_active": changed, "d_least": least, "feasible": self.feasible}
        self.v_before = v

    def _least(self, v, applied):
        if self.v_before is None:
            return 0.0, 0.0
        bot = self.robot
        force = ((applied[0] + applied[1]) / bot.r, bot.l * (applied[0] - applied[1]) / bot.r)
        first, second = (
            axis.least_push(self.v_before[i], v[i], force[i]) for i, axis in enumerate(self.axes)
        )
        return first, second


def times_that_count(delay, lag, T):
    """Time for which each earlier command matters, the latest first.

    It lasts until the next one takes over completely, plus the remainder of the lag.
    """
    if lag == 0.0:
        count = math.ceil(delay / T - 1e-9)
        return [min(T, delay - age * T) for age in range(count)]
    left = [
        delay + lag - age * T if age * T <= delay else lag * math.exp((delay - age * T) / lag)
        for age in range(math.ceil((delay + 50.0 * lag) / T) + 1)
    ]
    return [earlier - later for earlier, later in pairwise(left)]


def axes_of(scenario):
    """Both axes' numbers, derived from the believed robot if the scenario omits them."""
    g, bot, noise = scenario.guard, scenario.robot, scenario.disturbance
    masses = (scenario.model.m or bot.m, scenario.model.I or bot.I)
    low = g.M_min or tuple((1.0 - g.mass_margin) * item for item in masses)
    high = g.M_max or tuple((1.0 + g.mass_margin) * item for item in masses)
    wheel = noise.std * (3.0 if math.isinf(noise.truncate) else noise.truncate)
    push = (2.0 * wheel / bot.r + g.d_model[0], 2.0 * wheel * bot.l / bot.r + g.d_model[1])
    push = (push[0] + noise.push[0], push[1] + noise.push[1])
    dbar, nbar = g.dbar or push, g.nbar or scenario.sensor.velocity_noise
    delay, lag, T = scenario.actuator.delay, scenario.actuator.lag, scenario.clock.control
    under_way = math.ceil(delay / T - 1e-9) + math.ceil(lag / T)
    u1, aimed = scenario.limits.v_u1, 1.0 - _SHRINK * (1 + under_way)
    times = g.alpha or 1.0 / T, T, delay + lag
    rows = zip(u1, low, high, dbar, nbar, g.f_min, g.f_speed, strict=True)
    return [GuardedAxis(*row, row[0] * aimed, *times) for row in rows]


def within(force, box):
    """Nearest force in the box; the upper bound wins."""
    lo, hi = box
    return min(max(force[0], lo[0]), hi[0]), min(max(force[1], lo[1]), hi[1])


def linear_first(force, safe, phi, half):
    """Force with the largest thrust that leaves room for the safe moment, then the moment; ``phi``
    = 2 tau_max/r.
    """
    room = phi - abs(safe[1]) / half
    thrust = min(max(force[0], -room), room)
    rest = half * (phi - abs(thrust))
    return thrust, min(max(force[1], -rest), rest)


def rotation_first(force, safe, phi, half):
    """Force with the largest moment that leaves room for the safe thrust, then the thrust."""
    room = half * (phi - abs(safe[0]))
    moment = min(max(force[1], -room), room)
    rest = phi - abs(moment) / half
    return min(max(force[0], -rest), rest), moment
