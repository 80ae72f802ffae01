"""Peak gain of a linear speed loop: how far commands of at most 1 can drive the speed.

    second order   v'' + 2 z w0 v' + w0^2 v = w0^2 (K u + d)
    PI loop        M v' = F - c v + d,  F = kp (u - v) + f,  f' = ki (u - v)

N, the integral of the impulse response's size, is the largest |v| that any commands |u| <= 1 reach
from rest, held, late, lost or jittering as they may be; no smaller number is (Boyd, Doyle 1987).
With r = exp(-pi z/w), w = sqrt(1 - z^2) what half a swing leaves (0 for z >= 1):

    second order   N = K (1 + r)/(1 - r)
    PI loop        N = 1 + 2 o/(1 - r),  o = exp(-2 z acos(z)/w),  z = kp/(2 sqrt(ki M)),  c = 0
    its push       4 z exp(-z acos(z)/w)/(1 - r) dbar/(kp + c),    z = (kp + c)/(2 sqrt(ki M))

N falls with z and with c, the last rises with z at one kp + c (`filter.peak-worst`), so that each
is largest at one corner of the family, whatever the other numbers are.  There it is computed in
intervals that are rounded outward.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from wmr_ctrl.filter.enclosure import Span, exp, increasing, root, square
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.symbolic import ca

NEAR_ONE = 2.0**-20
"""Dampings nearer to 1 are taken for one so far away, on the side where the bound is larger."""

PI = Span.of(np.pi, np.nextafter(np.pi, np.inf))

Value = TypeVar("Value", Span, "ca.SX")
"""A formula's quantity: an interval, or a symbol for a proof of it."""


@dataclass(frozen=True)
class PeakGain:
    """Largest |v| per commanded speed, and the largest that the push alone causes [m/s, rad/s]."""

    gain: float
    push: float


@dataclass(frozen=True)
class PiLoop:
    """Family of PI loops of one axis, all numbers intervals: M, kp, ki, c, at the wheels' rim.

    kg, N.s/m, N/m, N.s/m; of the angular axis over l^2.
    """

    M: tuple[float, float]
    kp: tuple[float, float]
    ki: tuple[float, float]
    c: tuple[float, float]

    def peak(self, push: float) -> PeakGain:
        """Peak gain of the whole family; ``push`` [N] is the largest of its disturbances."""
        (M, M_max), (ki, ki_max), kp, c = self.M, self.ki, self.kp[0], self.c[0]
        least = Span.of(kp) / (2 * root(Span.of(ki_max) * M_max))
        gain = pi_gain(*_swing(_off_one(float(least.lo), -1)))
        held = Span.of(kp) + c
        most = held / (2 * root(Span.of(ki) * M))
        damping = _off_one(float(most.hi), 1)
        pushed = float((pi_push(*_swing(damping)) * push / held).hi) if push else 0.0
        return PeakGain(float(gain.hi), pushed)


def peak_gains(scenario: Scenario) -> tuple[PeakGain, PeakGain]:
    """Peak gains of v's and omega's linear loop, as a scenario's filter states them."""
    settings = scenario.filter
    if settings.loop == "second-order":
        damping, K = settings.interval("damping")[0], settings.gain[1]
        v, omega = (second_order(damping, K, d) for d in settings.d)
        return v, omega
    force, moment = settings.push
    at_rim = over_square((0.0, moment), scenario.robot.l)[1]
    return pi_loop(scenario, 0).peak(force), pi_loop(scenario, 1).peak(at_rim)


def pi_loop(scenario: Scenario, axis: int) -> PiLoop:
    """Family of PI loops of an axis, as a scenario's filter states it."""
    settings, l = scenario.filter, scenario.robot.l
    kp, ki, c = settings.interval("kp"), settings.interval("ki"), settings.friction
    M = over_square(settings.interval("inertia"), l) if axis else settings.interval("mass")
    return PiLoop(M, kp, ki, c)


def over_square(values: tuple[float, float], l: float) -> tuple[float, float]:
    """Bounds of values over l^2: the first from below, the second from above."""
    least, most = (Span.of(value) / square(Span.of(l)) for value in values)
    return max(float(least.lo), 0.0), float(most.hi)


def second_order(damping: float, gain: float, d: float) -> PeakGain:
    """Peak gain of loops with at least this damping and at most this gain at rest.

    ``d``: the speed at which the push alone would end.
    """
    z, _, left = _swing(_off_one(damping, -1))
    most = second_order_gain(z, left)
    return PeakGain(float((most * gain).hi), float((most * d).hi) if d else 0.0)


def second_order_gain(z: Value, left: Value) -> Value:
    """(1 + r)/(1 - r) with r = ``left``; z is not needed."""
    return (1 + left) / (1 - left)


def pi_gain(z: Value, ratio: Value, left: Value) -> Value:
    """1 + 2 exp(-2 z acos(z)/w)/(1 - r), ``ratio`` = acos(z)/w."""
    return 1 + 2 * _exp(-2 * z * ratio) / (1 - left)


def pi_push(z: Value, ratio: Value, left: Value) -> Value:
    """4 z exp(-z acos(z)/w)/(1 - r)."""
    return 4 * z * _exp(-(z * ratio)) / (1 - left)


def overshoot(scenario: Scenario) -> tuple[float, float]:
    """Largest overshoot of a step of v and of omega, as a share of it, for what is told.

    In doubles, of the corner where N is largest.
    """
    v, omega = (_overshoot(scenario, z) for z in _dampings(scenario))
    return v, omega


def less_damped(scenario: Scenario, axis: int, more: float) -> float:
    """Share of its damping that is left to a base whose steps overshoot by ``more`` more."""
    z = _dampings(scenario)[axis]
    wanted, low, high = _overshoot(scenario, z) + more, 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _overshoot(scenario, middle * z) < wanted else (middle, high)
    return low


BISECTIONS = 40


def _dampings(scenario: Scenario) -> tuple[float, float]:
    """Least damping of both axes: of PI loops without friction."""
    settings = scenario.filter
    if settings.loop == "second-order":
        z = settings.interval("damping")[0]
        return z, z
    v, omega = (pi_loop(scenario, axis) for axis in (0, 1))
    return _least_damping(v), _least_damping(omega)


def _least_damping(loop: PiLoop) -> float:
    return float(loop.kp[0] / (2 * (loop.ki[1] * loop.M[1]) ** 0.5))


def _overshoot(scenario: Scenario, damping: float) -> float:
    z, ratio, left = _swing(_off_one(damping, -1))
    own = left if scenario.filter.loop == "second-order" else _exp(-2 * z * ratio)
    return float(own.hi)


def _exp(value: Value) -> Value:
    return exp(value) if isinstance(value, Span) else ca.exp(value)


def _off_one(z: float, way: int) -> float:
    """The damping, or one that is not near 1, smaller for ``way`` -1 and larger for 1."""
    return 1 + way * NEAR_ONE if abs(z - 1) < NEAR_ONE else z


def _swing(damping: float) -> tuple[Span, Span, Span]:
    """z, acos(z)/w and r = exp(-pi z/w); beyond 1 acosh(z)/sqrt(z^2 - 1) and 0."""
    z = Span.of(damping)
    w = root(((1 - z) * (1 + z)).magnitude)
    if damping >= 1:
        return z, increasing(np.arccosh, z) / w, Span.of(0.0)
    return z, increasing(np.arctan, w / z) / w, exp(-(PI * z / w))
