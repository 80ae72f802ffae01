"""Longest control period: the linear loop, the barrier's kink, the first step.

The linear loop is that of the graphs that run, along the reference (`world`).  Its state:
e (3) and v (2) of the robot, what drives and sensors keep, and the law's memory, its observer
included, but for estimates and weights.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import PERIOD, Loop
from wmr_ctrl.checks.radius import (
    MARGIN,
    RATIO,
    SHORTEST,
    edge,
    largest_radius,
    only_forwards,
    supremum,
)
from wmr_ctrl.checks.sending import loop_of
from wmr_ctrl.checks.surroundings import delays_by_name, oldest_shown
from wmr_ctrl.checks.torques import first_torques
from wmr_ctrl.checks.warning import SPEEDS, UNITS, Warning, gains_that_fit, joined
from wmr_ctrl.checks.world import Floats
from wmr_ctrl.control.setup import settle
from wmr_ctrl.fields.arguments import checks_arguments
from wmr_ctrl.fields.values import LARGEST
from wmr_ctrl.model.dynamics import plant, rk4_step
from wmr_ctrl.scenario import Scenario, override
from wmr_ctrl.world.effect import EffectRole

SAFE = 0.5
"""Share of a stability limit that the remedies propose."""

MOST_UNDER_WAY = 40
"""Commands that the shortest period that is tried leaves under way in a delay."""

MASSES, NEAR, CLOSE = 20.0, (0.6, 1.6), (0.8, 1.25)
"""Ratios of true to believed mass: tried; to be stood; and those that a load soon reaches."""

MOST_STEPS = 500


def sample_time(loop: Loop) -> Iterator[Warning]:
    """Yield the limits that the control period exceeds, each with its number."""
    yield from _linear(loop)
    if loop.setup.takes_velocity:
        return
    if loop.has_barrier and not loop.guarded:
        yield from _kink(loop)
    inside = (np.abs(loop.start.v) <= loop.scenario.limits.v_u1).all()
    if inside and not loop.setup.with_role(EffectRole.DRIVE):
        yield from _first_step(loop)


def kink_limits(loop: Loop, period: float | None = None) -> Floats:
    """Longest period (2) [s] that is stable at the barrier's kink, |v| = v_u2 with v_c0 beyond it.

    There the force pulls towards v_u2 with its full slope, twice that of the linear loop, so a
    period below 2 M1/slope is needed: 2/rho for the model-based law.  The slope is that of a law
    that runs at ``period``, by default the scenario's.
    """
    u1, u2 = (np.array(limit) for limit in (loop.scenario.limits.v_u1, loop.scenario.limits.v_u2))
    slope = -loop.slope_towards(u2, u2 + 0.5 / (u1 - u2), period)
    mass = np.array((loop.scenario.robot.m, loop.scenario.robot.I))
    return np.asarray(2 * mass / np.maximum(slope, 1e-300))


def _linear(loop: Loop) -> Iterator[Warning]:
    period, (low, limit) = loop.scenario.clock.control, stable_periods(loop)
    if period > loop.longest:
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is longer than base.timeout = {loop.longest:g} s: the "
            "base stops before each command, and stability is not computed for that. Shorten "
            "clock.control, or raise base.timeout if the base has a longer one.",
            "docs/linear.md",
        )
        return
    if not loop.traits.auxiliary and (slowest := only_forwards(loop)):
        yield Warning(
            "reference",
            f"{loop.law} follows a reference that moves forwards, and v1_d of this one falls to "
            f"{slowest:.4g} m/s, that is backwards, where errors do not fade. Ask for a reference "
            "that keeps moving forwards, or take another law.",
            f"{loop.equations}, linearised",
        )
        return
    words = delays_by_name(loop.setup)
    late = "".join(f"a {word} of {value:g} s and " for word, value in words.items())
    if limit == 0:
        lower = f"the {' and '.join(words)}, or its gains" if late else "its gains"
        least = shortest_tried(loop)
        others = f" and at every shorter period that was tried (from {least:.3g} s up)"
        beginning = (
            f"{loop.law} is unstable around the reference with {late}these gains at "
            f"clock.control = {period:g} s{others if least < period else ''}"
        )
        if _blames_gain(loop):
            linear, angular = loop.scenario.base.gain
            yield Warning(
                "base.gain",
                f"{beginning}: what is sent counts on base.gain = [1, 1], with which it is stable, "
                f"and the base's is [{linear:g}, {angular:g}]. Have its driver divide commands by "
                "that, and do not lower the law's gains.",
                f"{loop.equations}, linearised",
            )
            return
        yield Warning(
            PERIOD,
            f"{beginning}: lower {lower}{gains_that_fit(loop, _stable)}.",
            f"{loop.equations}, linearised",
        )
    elif period >= limit:
        choice = f"{low:.3g} to {limit:.3g} s" if low else f"{SAFE * limit:.2g} s or less"
        delay = loop.around.drives.delay
        total = f" (period and delay together {limit + delay:.4g} s)" if delay else ""
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is above {limit:.4g} s, the longest period for which "
            f"{loop.law} is stable around the reference with {late}these gains{total}: "
            f"choose {choice}, or lower the gains{gains_that_fit(loop, _stable)}.",
            f"{loop.equations}, linearised and sampled",
        )
    else:
        yield from _mass(loop)


def _mass(loop: Loop) -> Iterator[Warning]:
    """Yield a robot unlike the believed one, from which on the loop is unstable, if it is near."""
    masses = stable_masses(loop)
    if masses is None or _stands(loop):
        return
    yield Warning(
        "model.m",
        f"{loop.law} is stable around the reference only while the robot's mass and inertia are "
        f"{masses[0]:.3g} to {masses[1]:.3g} times the believed ones, at clock.control = "
        f"{loop.scenario.clock.control:g} s; outside this range it cycles. Gains for {NEAR[0]:g} "
        f"to {NEAR[1]:g} are lower{gains_that_fit(loop, _stands)}.",
        f"{loop.equations}, linearised and sampled",
        objects=masses[0] > CLOSE[0] or masses[1] < CLOSE[1],
    )


def _stable(loop: Loop) -> bool:
    return loop.scenario.clock.control < stable_periods(loop)[1]


def _blames_gain(loop: Loop) -> bool:
    """Whether a base that takes velocities would be stable if its gain were 1."""
    if not loop.setup.takes_velocity:
        return False
    right = override(loop.scenario, {"base.gain": [1.0, 1.0], "filter.kind": "none"})
    return _stable(loop_of(settle(right, loop.law)))


def _stands(loop: Loop) -> bool:
    """Whether the loop is stable with every mass that is near the believed one."""
    masses = stable_masses(loop)
    return masses is not None and masses[0] <= NEAR[0] and masses[1] >= NEAR[1]


def _kink(loop: Loop) -> Iterator[Warning]:
    period, limits = loop.scenario.clock.control, kink_limits(loop)
    if (period >= limits).any():
        pairs = zip(SPEEDS, limits, strict=True)
        named = joined(f"{limit:.4g} s for {name}" for name, limit in pairs)
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is too long for {loop.law} where the barrier begins, at "
            f"v_u2 (the bounds are {named}): while the error is large the velocity swings about "
            f"v_u2 and may leave the limit. Choose {SAFE * min(limits):.2g} s or less.",
            "Eqs. (9)-(15), kink at v_u2",
        )


def _first_step(loop: Loop) -> Iterator[Warning]:
    period, limits = loop.scenario.clock.control, np.array(loop.scenario.limits.v_u1)
    reached, outer = first_speeds(loop), "(7), " if loop.traits.auxiliary else ""
    axes = np.flatnonzero(reached > limits)
    if axes.size:
        named = joined(
            f"{SPEEDS[i]} to {reached[i]:.3g} {UNITS[i]} (limit {limits[i]:g})" for i in axes
        )
        yield Warning(
            PERIOD,
            f"The first torque of {loop.law}, held for clock.control = {period:g} s, takes "
            f"{named}: the limit is broken before the second sample. Shorten clock.control, or "
            "start nearer to the reference.",
            f"Eqs. (4), {outer}one held step",
        )


@checks_arguments
def largest_stable_period(scenario: Scenario, law: str) -> float:
    """Supremum [s] of the stable periods about the scenario's, or of the next below.

    Over all points of the reference; 0.0 if the scenario's period and all shorter ones that were
    tried are unstable, inf if all longer ones (up to 10 s) are stable.  Raises UnknownNameError
    for a law.
    """
    return largest_period(loop_of(settle(scenario, law)))


@dataclass(frozen=True)
class Stability:
    """Around the reference: stable periods, largest delay [s], ratios of true to believed mass.

    Delay and masses are for the scenario's period; see the functions of these names. ``tried`` is
    the shortest period that was looked at; ``held``: beyond which the base stops between commands.
    """

    shortest: float
    period: float
    delay: float | None
    masses: tuple[float, float] | None
    tried: float
    held: float = math.inf

    @property
    def mass_words(self) -> str:
        """The ratios in words; an end of the range that was tried is no limit."""
        low, high = self.masses or (math.nan, math.nan)
        less, more = " or less" * (low <= 1 / MASSES), " or more" * (high >= MASSES)
        return f"{low:.3g}{less} to {high:.3g}{more} times the believed one"


def stability(scenario: Scenario, law: str) -> Stability:
    """All three for a law on a scenario; raises UnknownNameError for a law."""
    loop = loop_of(settle(scenario, law))
    delay, masses = largest_stable_delay(loop), stable_masses(loop)
    return Stability(*stable_periods(loop), delay, masses, shortest_tried(loop), loop.longest)


def largest_period(loop: Loop) -> float:
    """The same for a Loop that is at hand."""
    return stable_periods(loop)[1]


@lru_cache(maxsize=64)
def stable_periods(loop: Loop) -> tuple[float, float]:
    """Ends [s] of the stretch of stable periods that holds the scenario's, or of the next below.

    The lower end is 0.0 where all shorter ones that were tried are stable too, which a delay can
    prevent; (0.0, 0.0) where the scenario's period and all shorter ones that were tried are not.
    """
    shortest, inside = shortest_tried(loop), loop.scenario.clock.control

    @cache
    def of(period: float) -> float:
        return largest_radius(loop, period)

    outside = math.inf
    while of(inside) > 1 + MARGIN:
        outside, inside = inside, inside / RATIO
        if inside < shortest:
            return 0.0, 0.0
    high = edge(of, inside, outside) if outside < math.inf else supremum(of, inside)
    below = inside
    while below >= shortest and of(below) <= 1 + MARGIN:
        below /= RATIO
    return (edge(of, below * RATIO, below) if below >= shortest else 0.0), high


def shortest_tried(loop: Loop) -> float:
    """The shortest period that is tried [s]: so many commands may be under way, and no more."""
    late = max(loop.around.drives.delay, loop.setup.prediction)
    return max(SHORTEST, (late + oldest_shown(loop.setup)) / MOST_UNDER_WAY)


def largest_stable_delay(loop: Loop) -> float | None:
    """Supremum of the drives' delay [s] at the scenario's period, its lag and sensors as they are.

    None where the loop is unstable without any; inf where all that were tried, up to 40 periods,
    are stable.  A law that predicts is tried from the scenario's delay on.
    """
    period = loop.scenario.clock.control
    own = loop.around.drives
    least = own.delay if loop.setup.prediction else 0.0

    def of(delay: float) -> float:
        known = max(delay - (own.delay - own.known), 0.0)
        late = replace(own, delay=delay, known=known)
        return largest_radius(loop.with_delay(known), period, late)

    return _last(of, least, [least + k * period / 8 for k in range(1, 8 * MOST_UNDER_WAY)])


@lru_cache(maxsize=64)
def stable_masses(loop: Loop) -> tuple[float, float] | None:
    """Smallest and largest ratio of true to believed mass and inertia with a stable loop.

    Both are scaled alike, at the scenario's period; tried from 1/20 to 20, as far as a scenario
    can state them.  None for a law that believes no mass, and where the loop is unstable with the
    believed one.
    """
    if not loop.traits.model:
        return None
    believed = loop.scenario.believed

    def of(ratio: float) -> float:
        robot = replace(loop.scenario.robot, m=ratio * believed.m, I=ratio * believed.I)
        return largest_radius(loop, loop.scenario.clock.control, robot=robot)

    steps = [RATIO**k for k in range(1, round(math.log(MASSES) / math.log(RATIO)) + 1)]
    heavier = [step for step in steps if step * max(believed.m, believed.I) <= LARGEST]
    up = _last(of, 1.0, heavier) if heavier else math.inf
    down = _last(of, 1.0, [1 / step for step in steps])
    return None if up is None or down is None else (max(down, 1 / MASSES), min(up, MASSES))


def _last(of: Callable[[float], float], start: float, tried: Sequence[float]) -> float | None:
    """Stability limit along ``tried``, inf if none is met; None if unstable at ``start``."""
    of = cache(of)
    if of(start) > 1 + MARGIN:
        return None
    inside = start
    for value in tried:
        if of(value) > 1 + MARGIN:
            return edge(of, inside, value)
        inside = value
    return math.inf if inside > start else 0.0


def first_speeds(loop: Loop) -> Floats:
    """Largest |v1| [m/s] and |omega| [rad/s] while the first torque is held, drives ideal."""
    scenario, robot = loop.scenario, plant(loop.scenario)
    inputs = np.zeros(robot.u.numel())
    inputs[:2] = first_torques(loop.setup)
    steps = min(scenario.clock.substeps, MOST_STEPS)
    step = robot.function("step", [rk4_step(robot, ca.SX(scenario.clock.control / steps))])
    state, largest = np.array(robot.x0), np.abs(loop.start.v)
    for _ in range(steps):
        state = np.asarray(step(inputs, state, robot.p0)).ravel()
        largest = np.maximum(largest, np.abs(state[3:]))
    return largest
