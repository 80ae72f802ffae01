"""Speed loops of a simulated base, whose force is held over each plant step.

Holding the force makes a PI loop oscillate more.

A step h changes the speed by (h/M)(F - c v + d), F = kp (u - v) + f, and f by h ki (u - v).  These
are the steps of Euler's method for the loop with the same numbers.  With

    a = (kp + c)/M,   b = ki/M,   gamma = c/M,   w^2 = b - a^2/4,   g = 1 - h a/2
    R = arctan(q)/(q g),   q = h w/g,   artanh where q^2 < 0

the remainder of a step of the command after k plant steps is e(k h), e of `step_response` with

    a' = -ln(1 - h a + h^2 b)/h,   w' = w R,   b' = w'^2 + a'^2/4,   gamma' = a'/2 + (gamma - a/2) R

So the response to a force of one step is a difference of R phi/M at two instants, where phi is the
impulse response of the loop with those numbers.  Sums of |changes| over instants are no larger than
integrals of |slopes|: N and the response to pushes are at most those of that loop. gamma' may be
below 0.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wmr_ctrl.core.fields.units import rounded
from wmr_ctrl.world.effect import ROUNDING, Bound, Pair
from wmr_ctrl.world.model.system import Number
from wmr_ctrl.world.phases import full_friction, phases, steepness
from wmr_ctrl.world.resistance import Resistance
from wmr_ctrl.world.scenario import Scenario
from wmr_ctrl.world.speed_loop import has_loop
from wmr_ctrl.world.speed_loop_pi import PiLoopGains

from .enclosure import Floats, Span, exp, increasing, root, square

STABLE = 2.785
"""Steps of Runge and Kutta in such times up to which v goes between none and all of its way."""
PI = Span.of(np.pi, np.nextafter(np.pi, np.inf))


@dataclass(frozen=True)
class Through:
    """Continuous loop through a held loop's samples: intervals of a, b, gamma, w^2 and R."""

    a: Span
    b: Span
    gamma: Span
    w2: Span
    ratio: Span
    mass: Span


@dataclass(frozen=True)
class HeldLoop:
    """Numbers of one axis of a simulated PI base, at the wheels' rim, and its plant step [s]."""

    M: tuple[float, float]
    kp: float
    ki: float
    c: tuple[float, float]
    step: float

    def through(self) -> Through | None:
        """Continuous loop through the samples; None if the held loop is too fast for its steps.

        That is so if an oscillation changes its sign with every step, does not decay, or exceeds
        the step.
        """
        h, mass, ki, c = self.step, Span.of(*self.M), Span.of(self.ki), Span.of(*self.c)
        a, b, gamma = (self.kp + c) / mass, ki / mass, c / mass
        w2, left = b - 0.25 * square(a), 1 - 0.5 * h * a
        lost = h * (a - h * b)
        if not (left.lo > 0 and lost.lo > 0 and lost.hi < 1):
            return None
        turned = h * h * w2 / square(left)
        if not turned.lo > -1:
            return None
        ratio = arc_over(turned) / left
        faded = -increasing(np.log1p, -lost) / h
        own_w2 = square(ratio) * w2
        own_b = own_w2 + 0.25 * square(faded)
        own_gamma = 0.5 * faded + ratio * (gamma - 0.5 * a)
        largest = 1 - (faded - own_gamma) * own_gamma / own_b
        if own_w2.hi > 0 and (largest * exp(-(PI * faded / root(Span.of(own_w2.hi))))).hi > 1:
            return None
        return Through(faded, own_b, own_gamma, own_w2, ratio, mass)


def held_loop(scenario: Scenario, axis: int) -> HeldLoop | None:
    """Held loop of the simulated base of a scenario with a filter for PI loops; None without
    one.
    """
    if not has_loop(scenario, "pi", [axis]):
        return None
    robot, gains = scenario.robot, scenario.section(PiLoopGains)
    over = square(Span.of(robot.l)) if axis else Span.of(1.0)
    M = Span.of((robot.m, robot.I)[axis]) / over
    c = Span.of(scenario.section(Resistance).viscous[axis]) / over
    pairs = ((float(item.lo), float(item.hi)) for item in (M, c))
    mass, friction = pairs
    return HeldLoop(mass, gains.kp, gains.ki, (max(friction[0], 0.0), friction[1]),
                    scenario.clock.plant)  # fmt: skip


def too_quick(scenario: Scenario) -> Iterator[str]:
    """Objections to a simulated base whose held loop is too fast for any filter's bounds."""
    h = scenario.clock.plant
    for axis, name in enumerate(("v", "omega")):
        own = held_loop(scenario, axis)
        if own is not None and own.through() is None:
            yield (
                f"clock.plant = {h:g} s: the force of the loop of {name} is held for as long, and "
                f"with base.kp = {own.kp:g} N.s/m and base.ki = {own.ki:g} N/m it swings to and "
                "fro with these steps, or does not settle. Shorten clock.plant, or lower both."
            )


def push_speeds(scenario: Scenario, bound: Bound) -> Pair:
    """Steady speeds [m/s, rad/s] that pushes and command errors alone would cause.

    For a first-order loop, whose friction is compensated: d = s f/M + K times the error, with s =
    h/(1 - exp(-h/tau)).  This exceeds tau by half a plant step h, since the loop's force is held
    over it.  For a second-order loop: steady pushes with the same largest response as varying ones.
    0 for a PI loop, which compensates them.
    """
    if not scenario.takes_velocity:
        return 0.0, 0.0
    base, robots = scenario.base, [p.robot for p in phases(scenario)]
    mass, inertia = min(robot.m for robot in robots), min(robot.I for robot in robots)
    linear, angular = (
        _time_of_pushes(scenario, axis) * bound.dbar[axis] / (mass, inertia)[axis]
        + base.gain[axis] * bound.command[axis]
        if base.loop[axis] != "pi"
        else 0.0
        for axis in (0, 1)
    )
    return linear, angular


def _time_of_pushes(scenario: Scenario, axis: int) -> float:
    """Factor s [s] from a push's acceleration to its equivalent speed, for an axis' loop.

    A push on a second-order loop changes the speed as 1 - S does, with the step response S: at most
    by the integral of |1 - S|. Summing over plant steps adds at most one step h times its total
    variation.  The filter allows N times as much, with the peak gain N. With the damping z, the
    frequency w, and r, the remainder of an oscillation after half a turn:

        s = (2 z (1 - r) + 2 exp(-z (pi - acos z)/sqrt(1 - z^2)))/(w (1 + r)) + h

    and 2 z/w + h for z >= 1.
    """
    base, h = scenario.base, scenario.clock.plant
    if has_loop(scenario, "first-order", [axis]):
        return -h / math.expm1(-h / base.tau[axis])
    z, w = base.damping[axis], base.frequency[axis]
    if z >= 1:
        return 2 * z / w + h
    per_turn = z / math.sqrt(1 - z * z)
    r, crossed = math.exp(-math.pi * per_turn), math.exp(-(math.pi - math.acos(z)) * per_turn)
    return (2 * z * (1 - r) + 2 * crossed) / (w * (1 + r)) + h


def pace_of_friction(step: Number, slope: Number, mass: Number) -> Number:
    """x: slope of friction at rest over the mass, times the plant step of a first-order loop.

    The loop compensates the friction at the step's start, and friction's change within the step
    acts against the motion: at least a share 1 - x/2 of the way is covered
    (`filter.held-friction`).
    """
    return step * slope / mass


def quickest_friction(scenario: Scenario) -> float:
    """The largest x in a run."""
    h, robots = scenario.clock.plant, [phase.robot for phase in phases(scenario)]
    return max(pace_of_friction(h, steepness(robot), robot.m) for robot in robots)


def counts_on_rims(scenario: Scenario) -> bool:
    """True if a filter assumes that the rims follow first-order loops of their own."""
    stated = scenario.filter
    wheels = stated.kind == "governor" and stated.channels == "wheels"
    return (wheels or stated.wheel_speed is not None) and has_loop(scenario, "first-order")


def kick_of_friction(scenario: Scenario) -> float:
    """B [m/s]: largest deviation of v from its loop due to friction while one command acts.

    It is h times all of friction's range over the mass, 2 mu g (`filter.held-kick`).
    """
    ranges = (2 * full_friction(phase.robot) / phase.robot.m for phase in phases(scenario))
    return scenario.clock.plant * max(ranges)


def push_of_kick(kick: Number, gone: Number) -> Number:
    """Push [m/s] that causes a deviation ``kick`` while a loop covers the share ``gone``."""
    return kick / gone


def push_of_share(x: Number, most: Number) -> Number:
    """Push [m/s] equivalent to an error of x/2 of the speed change from ``most`` to rest in a
    step.
    """
    return x / 2 * most


def friction_at_a_rim(scenario: Scenario, push: float, bound: Bound) -> float:
    """Push [m/s] equivalent to friction if rims are limited, in addition to a ``push`` on v.

    It causes B in the time of a command, which is a plant step if the base itself changes commands,
    and covers the effect of alternating pushes near rest.  Behind a clip, whose commands are at
    most V, it need not exceed x/2 of V: friction carries a rim beyond its command only while v
    approaches rest (`filter.held-share`).
    """
    clock, x = scenario.clock, quickest_friction(scenario)
    acts = clock.plant if bound.hidden else max(clock.control - bound.jitter, clock.plant)
    gone = -math.expm1(-acts / scenario.base.tau[0])
    counted = push_of_kick(kick_of_friction(scenario), gone) + 2 * x * push
    clips = scenario.filter.kind == "clip"
    return min(counted, push_of_share(x, scenario.limits.v_u1[0])) if clips else counted


def held_friction(scenario: Scenario) -> Iterator[str]:
    """Objections to friction that changes too much within a plant step of a first-order loop."""
    stated, h, x = scenario.filter, scenario.clock.plant, quickest_friction(scenario)
    begin = f"Friction that changes within clock.plant = {h:g} s (robot.mu) "
    most = 2.0 if counts_on_rims(scenario) else STABLE
    if x > most:
        does = "may throw v beyond its command" if x > STABLE else "holds back v alone for steps"
        yield (
            f"{begin}{does} near rest: the step is {rounded(x, 3)} times friction's time constant "
            f"there. Shorten clock.plant to at most {rounded(h * most / x, 3, up=False)} s."
        )
        return
    if counts_on_rims(scenario):
        yield from _started_rims(scenario)
    slowest = math.inf
    if x < 2:
        slowest = -h / math.log1p(math.expm1(-h / scenario.base.tau[0]) * (1 - x / 2))
    governs = stated.kind == "governor" and stated.channels == "body"
    if not governs:
        return
    _, longest = stated.intervals("tau")[0]
    if slowest > longest * (1 + ROUNDING):
        more = f"Raise it to {rounded(slowest, 4)} s, or shorten" if x < 2 else "Shorten"
        yield (
            f"{begin}lets v change near rest more slowly than {stated.place('tau', 0, 2)} = "
            f"{longest:g} s says. {more} clock.plant."
        )


def _started_rims(scenario: Scenario) -> Iterator[str]:
    """Objections to a start from which friction may push a rim beyond its limit."""
    stated, l, (v, omega) = scenario.filter, scenario.robot.l, scenario.initial.velocity
    V, turn = scenario.limits.v_u1
    tops = (V, l * turn) if stated.channels == "wheels" else ()
    top = min(*tops, stated.wheel_speed or math.inf, math.inf) - kick_of_friction(scenario)
    if abs(v) + l * abs(omega) > top * (1 + ROUNDING):
        yield (
            f"initial.velocity = [{v:g}, {omega:g}]: a wheel starts at {abs(v) + l * abs(omega):g} "
            f"m/s, above {rounded(top, 4, up=False)} m/s, its limit less what friction leads to "
            "within plant steps. Start more slowly."
        )


def arc_over(x: Span) -> Span:
    """Enclosure of arctan(sqrt x)/sqrt x for x > -1, which is artanh(sqrt -x)/sqrt -x below 0.

    It decreases.  Near 0 the omitted terms of its series are below 1e-16.
    """
    return Span(_arc_over(x.hi) * (1 - 2.0**-48), _arc_over(x.lo) * (1 + 2.0**-48))


def _arc_over(x: Floats) -> Floats:
    near = np.abs(x) < 1e-3
    q = np.where(near, 0.5, np.sqrt(np.abs(x)))
    far = np.where(x < 0, np.arctanh(np.minimum(q, 1 - 2.0**-53)), np.arctan(q)) / q
    series = 1 - x * (1 / 3 - x * (1 / 5 - x * (1 / 7 - x * (1 / 9 - x / 11))))
    return np.where(near, series, far)
