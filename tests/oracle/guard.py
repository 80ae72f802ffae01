"""The velocity guard and the maps behind it, one axis after the other; and what only watches."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

_SHRINK = 2.0**-44


@dataclass(frozen=True, slots=True)
class GuardedAxis:
    """Numbers of one axis: limit, masses, bounds of disturbance and measurement, friction floor.

    ``aim`` is the limit less what rounding may cost, more with every command under way.
    """

    u1: float
    M_min: float
    M_max: float
    dbar: float
    nbar: float
    f_min: float
    f_speed: float
    aim: float

    def ceiling(self, y, alpha, T, brake, coming=0.0):
        """Largest force that is safe at the measured velocity ``y`` with a rise that is coming."""
        room = self.aim - max(y + self.nbar, self.f_speed) - coming
        gain = self.M_min * alpha if room >= 0.0 else self.M_max / T
        return max(gain * room - (self.dbar - self.f_min), -brake)

    def cap(self, alpha, delay):
        """The largest braking force that leaves room for as large a one to arrive too late."""
        room = self.aim - self.f_speed
        return self.M_min * alpha * room / (1.0 + alpha * delay) - (self.dbar - self.f_min)

    def largest(self, alpha, delay, brake):
        """What no force may exceed while it takes ``delay`` to arrive."""
        if delay == 0.0:
            return math.inf
        push = self.dbar - self.f_min
        room = self.aim - self.f_speed
        room -= max(brake + push, 0.0) / (self.M_min * alpha)
        return self.M_min * room / delay - push

    def rise(self, force, time):
        """Most that v can gain while ``force`` acts for ``time``."""
        return max(force + self.dbar - self.f_min, 0.0) * time / self.M_min

    def can_be_kept(self, alpha, T, brake, delay):
        """Whether the numbers make sense and braking outweighs the push wherever it has to."""
        sound = self.M_min <= self.M_max and self.f_speed < self.u1 and alpha * T <= 1.0
        seen = 2.0 * self.nbar <= self.aim
        push = self.dbar - self.f_min
        return sound and seen and self.cap(alpha, delay) >= push and brake >= push


class VelocityGuard:
    """Clips a force to what is safe, and watches whether the motion fits the bounds.

    An unguarded run has one too, which only watches.
    """

    def __init__(self, scenario, tau_max):
        self.T, self.robot, self.settings = scenario.clock.control, scenario.robot, scenario.guard
        self.alpha = scenario.guard.alpha or 1.0 / self.T
        delay, lag = scenario.actuator.delay, scenario.actuator.lag
        self.delay = delay + lag
        self.times = times_that_count(delay, lag, self.T)
        self.sent = [(0.0, 0.0)] * len(self.times)
        self.axes = axes_of(scenario)
        self.phi = 2.0 * tau_max / scenario.robot.r
        self.brakes = self._brakes()
        self.feasible = float(self._can_be_kept())
        self.v_before = None
        self.seen = {}
        self.memory_of((0.0, 0.0), (0.0, 0.0))

    def _brakes(self):
        first, second = (axis.cap(self.alpha, self.delay) for axis in self.axes)
        given, half = self.settings.brake, self.robot.l
        if given is not None:
            return min(first, given[0]), min(second, given[1])
        if math.isinf(self.phi):
            return first, second
        need = [max(axis.dbar - axis.f_min, 0.0) for axis in self.axes]
        spare = max(self.phi * (1.0 - _SHRINK) - need[0] - need[1] / half, 0.0)
        share = self.settings.brake_share
        return (
            min(first, need[0] + share * spare),
            min(second, need[1] + (1.0 - share) * spare * half),
        )

    def _can_be_kept(self):
        """Whether there is a safe force at every state, within the wheels' reach."""
        both = self.brakes[0] + self.brakes[1] / self.robot.l
        within_reach = both <= self.phi
        pairs = zip(self.axes, self.brakes, strict=True)
        return within_reach and all(
            a.can_be_kept(self.alpha, self.T, b, self.delay) for a, b in pairs
        )

    def box(self, v):
        """(lo, hi) of both axes, each a pair (thrust [N], moment [N m])."""
        return (-self._most(0, v, -1.0), -self._most(1, v, -1.0)), (
            self._most(0, v, 1.0),
            self._most(1, v, 1.0),
        )

    def _most(self, i, v, way):
        """Largest force of axis ``i`` that is safe in direction ``way``."""
        axis, brake = self.axes[i], self.brakes[i]
        coming = sum(
            axis.rise(way * force[i], time)
            for time, force in zip(self.times, self.sent, strict=True)
        )
        hi = axis.ceiling(way * v[i], self.alpha, self.T, brake, coming)
        return min(hi, axis.largest(self.alpha, self.delay, brake))

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
        """Take note of the sample at velocity ``v`` that the ``applied`` torque led to."""
        self.memory_of(changed, self._least(v, applied))
        self.v_before = v

    def memory_of(self, changed, least):
        """Note what is logged."""
        self.seen = {"clip_active": changed, "d_least": least, "feasible": self.feasible}

    def _least(self, v, applied):
        if self.v_before is None:
            return 0.0, 0.0
        bot = self.robot
        force = ((applied[0] + applied[1]) / bot.r, bot.l * (applied[0] - applied[1]) / bot.r)
        first, second = (
            least_push(axis, self.v_before[i], v[i], force[i], self.T)
            for i, axis in enumerate(self.axes)
        )
        return first, second


def least_push(axis, old, new, force, T):
    """Smallest disturbance that explains the step from ``old`` to ``new`` under ``force``."""
    if max(old, new) < -axis.nbar:
        return least_push(axis, -old, -new, -force, T)
    if min(old, new) <= axis.nbar:
        return 0.0
    rate = (new - old - 2.0 * axis.nbar) / T
    return max(0.0, min(axis.M_min * rate, axis.M_max * rate) - force)


def on_their_way(scenario):
    """How many commands have not ended when the next is computed."""
    return math.ceil(scenario.actuator.delay / scenario.clock.control - 1e-9)


def times_that_count(delay, lag, T):
    """For how long each earlier command counts, the latest first.

    Until the next one takes over in full, and what the lag leaves of it afterwards.
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
    """Both axes' numbers, derived from the believed robot where the scenario leaves them out."""
    g, bot, noise = scenario.guard, scenario.robot, scenario.disturbance
    masses = (scenario.model.m or bot.m, scenario.model.I or bot.I)
    low = g.M_min or tuple((1.0 - g.mass_margin) * item for item in masses)
    high = g.M_max or tuple((1.0 + g.mass_margin) * item for item in masses)
    wheel = noise.std * (3.0 if math.isinf(noise.truncate) else noise.truncate)
    push = (2.0 * wheel / bot.r + g.d_model[0], 2.0 * wheel * bot.l / bot.r + g.d_model[1])
    push = (push[0] + noise.push[0], push[1] + noise.push[1])
    dbar, nbar = g.dbar or push, g.nbar or scenario.sensor.velocity_noise
    roundings = on_their_way(scenario) + math.ceil(scenario.actuator.lag / scenario.clock.control)
    u1, aimed = scenario.limits.v_u1, 1.0 - _SHRINK * (1 + roundings)
    first, second = (
        GuardedAxis(
            u1[i], low[i], high[i], dbar[i], nbar[i], g.f_min[i], g.f_speed[i], u1[i] * aimed
        )
        for i in (0, 1)
    )
    return first, second


def within(force, box):
    """Nearest force in the box; the upper bound wins."""
    lo, hi = box
    return min(max(force[0], lo[0]), hi[0]), min(max(force[1], lo[1]), hi[1])


def linear_first(force, safe, phi, half):
    """The thrust as far as the safe moment leaves room, then the moment; ``phi`` = 2 tau_max/r."""
    room = phi - abs(safe[1]) / half
    thrust = min(max(force[0], -room), room)
    rest = half * (phi - abs(thrust))
    return thrust, min(max(force[1], -rest), rest)


def rotation_first(force, safe, phi, half):
    """The moment as far as the safe thrust leaves room, then the thrust."""
    room = half * (phi - abs(safe[0]))
    moment = min(max(force[1], -room), room)
    rest = phi - abs(moment) / half
    return min(max(force[0], -rest), rest), moment
