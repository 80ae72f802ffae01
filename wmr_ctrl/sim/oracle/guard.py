"""The velocity guard and the maps behind it, one axis after the other."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wmr_ctrl.scenario import Scenario
from wmr_ctrl.sim.oracle.law import Pair

_SHRINK = 2.0**-44


@dataclass(frozen=True, slots=True)
class Axis:
    """Numbers of one axis: limit, masses, bounds of disturbance and measurement, friction floor."""

    u1: float
    M_min: float
    M_max: float
    dbar: float
    nbar: float
    f_min: float
    f_speed: float

    def ceiling(self, y: float, alpha: float, T: float, brake: float) -> float:
        """Largest force that is safe at the measured velocity ``y``."""
        room = self.u1 * (1.0 - _SHRINK) - max(y + self.nbar, self.f_speed)
        gain = self.M_min * alpha if room >= 0.0 else self.M_max / T
        return max(gain * room - (self.dbar - self.f_min), -brake)

    def cap(self, alpha: float) -> float:
        """The largest force at rest."""
        room = self.u1 * (1.0 - _SHRINK) - self.f_speed
        return self.M_min * alpha * room - (self.dbar - self.f_min)


class VelocityGuard:
    """Clips a force to what is safe, and watches whether the motion fits the bounds."""

    def __init__(self, scenario: Scenario, tau_max: float) -> None:
        self.T, self.robot, self.settings = scenario.clock.control, scenario.robot, scenario.guard
        self.alpha = scenario.guard.alpha or 1.0 / self.T
        self.axes = axes_of(scenario)
        self.phi = 2.0 * tau_max / scenario.robot.r
        self.brakes = self._brakes()
        self.v_before: Pair | None = None
        self.seen: dict[str, object] = {}
        self.memory_of((0.0, 0.0), (0.0, 0.0))

    def _brakes(self) -> Pair:
        first, second = (axis.cap(self.alpha) for axis in self.axes)
        given, half = self.settings.brake, self.robot.l
        if given is not None:
            return min(first, given[0]), min(second, given[1])
        if math.isinf(self.phi):
            return first, second
        need = [max(axis.dbar - axis.f_min, 0.0) for axis in self.axes]
        spare = self.phi - need[0] - need[1] / half
        share = self.settings.brake_share
        return (
            min(first, need[0] + share * spare),
            min(second, need[1] + (1.0 - share) * spare * half),
        )

    def box(self, v: Pair) -> tuple[Pair, Pair]:
        """(lo, hi) of both axes, each a pair (thrust [N], moment [N m])."""
        hi = self._ceilings(v)
        lo = self._ceilings((-v[0], -v[1]))
        return (-lo[0], -lo[1]), hi

    def _ceilings(self, v: Pair) -> Pair:
        first, second = (
            axis.ceiling(v[i], self.alpha, self.T, self.brakes[i])
            for i, axis in enumerate(self.axes)
        )
        return first, second

    def act(self, asked: Pair, v: Pair, applied: Pair) -> Pair:
        """The force that may act, within the wheels' reach."""
        box = self.box(v)
        held, safe = within(asked, box), within((0.0, 0.0), box)
        changed = (float(held[0] != asked[0]), float(held[1] != asked[1]))
        self.memory_of(changed, self._least(v, applied))
        self.v_before = v
        reach = linear_first if self.settings.map == "linear-first" else rotation_first
        return reach(held, safe, self.phi, self.robot.l)

    def memory_of(self, changed: Pair, least: Pair) -> None:
        """Note what is logged."""
        self.seen = {"clip_active": changed, "d_least": least, "feasible": 1.0}

    def _least(self, v: Pair, applied: Pair) -> Pair:
        if self.v_before is None:
            return 0.0, 0.0
        bot = self.robot
        force = ((applied[0] + applied[1]) / bot.r, bot.l * (applied[0] - applied[1]) / bot.r)
        first, second = (
            least_push(axis, self.v_before[i], v[i], force[i], self.T)
            for i, axis in enumerate(self.axes)
        )
        return first, second


def least_push(axis: Axis, old: float, new: float, force: float, T: float) -> float:
    """Smallest disturbance that explains the step from ``old`` to ``new`` under ``force``."""
    if max(old, new) < -axis.nbar:
        return least_push(axis, -old, -new, -force, T)
    if min(old, new) <= axis.nbar:
        return 0.0
    rate = (new - old - 2.0 * axis.nbar) / T
    return max(min(axis.M_min * rate, axis.M_max * rate) - force, 0.0)


def axes_of(scenario: Scenario) -> tuple[Axis, Axis]:
    """Both axes' numbers, derived from the robot where the scenario leaves them out."""
    g, bot, noise = scenario.guard, scenario.robot, scenario.disturbance
    masses = [[bot.m], [bot.I]]
    for change in scenario.changes:
        for listed, value in zip(masses, (change.m, change.I), strict=True):
            listed += [] if value is None else [value]
    low = g.M_min or tuple((1.0 - g.mass_margin) * min(item) for item in masses)
    high = g.M_max or tuple((1.0 + g.mass_margin) * max(item) for item in masses)
    wheel = noise.std * (3.0 if math.isinf(noise.truncate) else noise.truncate)
    push = (2.0 * wheel / bot.r + g.d_model[0], 2.0 * wheel * bot.l / bot.r + g.d_model[1])
    push = (push[0] + noise.push[0], push[1] + noise.push[1])
    dbar, nbar = g.dbar or push, g.nbar or scenario.sensor.velocity_noise
    u1 = scenario.limits.v_u1
    first, second = (
        Axis(u1[i], low[i], high[i], dbar[i], nbar[i], g.f_min[i], g.f_speed[i]) for i in (0, 1)
    )
    return first, second


def within(force: Pair, box: tuple[Pair, Pair]) -> Pair:
    """Nearest force in the box; the upper bound wins."""
    lo, hi = box
    return min(max(force[0], lo[0]), hi[0]), min(max(force[1], lo[1]), hi[1])


def linear_first(force: Pair, safe: Pair, phi: float, half: float) -> Pair:
    """The thrust as far as the safe moment leaves room, then the moment; ``phi`` = 2 tau_max/r."""
    room = phi - abs(safe[1]) / half
    thrust = min(max(force[0], -room), room)
    rest = half * (phi - abs(thrust))
    return thrust, min(max(force[1], -rest), rest)


def rotation_first(force: Pair, safe: Pair, phi: float, half: float) -> Pair:
    """The moment as far as the safe thrust leaves room, then the thrust."""
    room = half * (phi - abs(safe[0]))
    moment = min(max(force[1], -room), room)
    rest = phi - abs(moment) / half
    return min(max(force[0], -rest), rest), moment
