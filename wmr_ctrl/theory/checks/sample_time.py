"""Longest control period, from the linear loop, the barrier's kink, and the first step.

The linear loop is that of the graphs that run, along the reference (`world`).  Its state: e (3) and
v (2) of the robot, the states of drives and sensors, and the law's memory including its observer,
without estimates and weights.
"""

from collections.abc import Iterator

import casadi as ca
import numpy as np

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.setup import settle
from wmr_ctrl.results import NOT_CHECKED
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.effect import EffectRole
from wmr_ctrl.world.model.dynamics import plant, rk4_step
from wmr_ctrl.world.scenario import override

from .budget import OverBudgetError
from .error_coordinates import Floats
from .loop import PERIOD, Loop
from .radius import MARGIN, RATIO, largest_radius, only_forwards
from .sending import loop_of
from .stable_ranges import (
    distance_at_rest,
    shortest_tried,
    stable_masses,
    stable_periods,
)
from .surroundings import delays_by_name
from .torques import first_torques
from .warning import SPEEDS, UNITS, as_tuned, joined

SAFE = 0.5
"""Share of a stability limit that the remedies propose."""

NEAR, CLOSE = (0.6, 1.6), (0.8, 1.25)
"""Ratios of true to believed mass that are to be stood, and those that a load soon reaches."""
BEYOND_NEAR = RATIO**4
"""The first ratio of those tried that is beyond all that are near, as one over it is."""

MOST_STEPS = 500


def sample_time(loop: Loop) -> Iterator[Warning]:
    """Yield the limits that the control period exceeds, each with its number."""
    try:
        yield from _linear(loop)
    except OverBudgetError:
        yield Warning(
            NOT_CHECKED,
            f"The stability of {loop.law} around the reference was not checked to the end: it "
            f"takes more work than is allowed here. {checked_by(loop.law)}.",
            f"{loop.equations}, linearised",
            objects=False,
        )
    if loop.setup.takes_velocity:
        return
    if loop.has_barrier and not loop.guarded:
        yield from _kink(loop)
    inside = (np.abs(loop.start.v) <= loop.scenario.limits.v_u1).all()
    if inside and not loop.setup.with_role(EffectRole.DRIVE):
        yield from _first_step(loop)


def kink_limits(loop: Loop, period: float | None = None) -> Floats:
    """Longest period (2) [s] that is stable at the barrier's kink, |v| = v_u2 with v_c0 beyond it.

    There the slope of the force towards v_u2 is twice that of the linear loop, so a period below 2
    M1/slope is needed: 2/rho for the model-based law.  The slope is that of a law that runs at
    ``period``, by default the scenario's.
    """
    u1, u2 = (np.array(limit) for limit in (loop.scenario.limits.v_u1, loop.scenario.limits.v_u2))
    slope = -loop.slope_towards(u2, u2 + 0.5 / (u1 - u2), period)
    mass = np.array((loop.scenario.robot.m, loop.scenario.robot.I))
    return np.asarray(2 * mass / np.maximum(slope, 1e-300))


def _linear(loop: Loop) -> Iterator[Warning]:
    if (reason := next(_without_loop(loop), None)) is not None:
        yield reason
        return
    if _stable(loop):
        yield from _mass(loop)
        return
    try:
        yield _unstable(loop)
    except OverBudgetError:
        yield Warning(
            PERIOD,
            f"{loop.law} is unstable around the reference with these gains at clock.control = "
            f"{loop.scenario.clock.control:g} s: shorten it, or lower the gains. The longest "
            f"stable period takes more work than is allowed here. {checked_by(loop.law)}.",
            f"{loop.equations}, linearised and sampled",
        )


def checked_by(law: str) -> str:
    """Sentence, without its full stop, on the command that checks a law without a work limit."""
    return f"`wmr-ctrl check --law {LAWS.spelled(law)}` has no such limit, and may take minutes"


def _unstable(loop: Loop) -> Warning:
    """Warning about a loop that is unstable at its control period, with the stable periods."""
    period, (low, limit) = loop.scenario.clock.control, stable_periods(loop)
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
            return Warning(
                "base.gain",
                f"{beginning}: the law assumes base.gain = [1, 1], with which it is stable, "
                f"and the base's is [{linear:g}, {angular:g}]. Have its driver divide commands by "
                "that, and do not lower the law's gains.",
                f"{loop.equations}, linearised",
            )
        return Warning(
            PERIOD,
            f"{beginning}: lower {lower}{as_tuned(loop)}.",
            f"{loop.equations}, linearised",
        )
    choice = f"{low:.3g} to {limit:.3g} s" if low else f"{SAFE * limit:.2g} s or less"
    delay = loop.around.drives.delay
    total = f" (period and delay together {limit + delay:.4g} s)" if delay else ""
    return Warning(
        PERIOD,
        f"clock.control = {period:g} s is above {limit:.4g} s, the longest period for which "
        f"{loop.law} is stable around the reference with {late}these gains{total}: "
        f"choose {choice}, or lower the gains{as_tuned(loop)}.",
        f"{loop.equations}, linearised and sampled",
    )


def _without_loop(loop: Loop) -> Iterator[Warning]:
    """Yield reasons why there is no linear loop, or none that could be stable."""
    period = loop.scenario.clock.control
    if period > loop.longest:
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is longer than base.timeout = {loop.longest:g} s: the "
            "base stops before each command, and stability is not computed for that. Shorten "
            "clock.control, or raise base.timeout if the base has a longer one.",
            "docs/linear.md",
        )
    if not loop.traits.auxiliary and (slowest := only_forwards(loop)):
        yield Warning(
            "reference",
            f"{loop.law} follows a reference that moves forwards, and v1_d of this one falls to "
            f"{slowest:.4g} m/s, that is backwards, where errors do not fade. Ask for a reference "
            "that keeps moving forwards, or take another law.",
            f"{loop.equations}, linearised",
        )
    if distance_at_rest(loop) is None:
        yield Warning(
            "base.gain" if _blames_gain(loop) else "reference",
            f"{loop.law} does not rest near the reference within the limits, so there is no loop "
            "to call stable. Ask for a slower reference, have the base's driver divide commands by "
            "base.gain if that is not [1, 1], or take another law.",
            f"{loop.equations}, sampled",
        )


def _mass(loop: Loop) -> Iterator[Warning]:
    """Yield the ratios of true to believed mass outside which the loop is unstable, if near 1."""
    if not loop.traits.model or _stands(loop) or (masses := stable_masses(loop)) is None:
        return
    yield Warning(
        "model.m",
        f"{loop.law} is stable around the reference only while the robot's mass and inertia are "
        f"{masses[0]:.3g} to {masses[1]:.3g} times the believed ones, at clock.control = "
        f"{loop.scenario.clock.control:g} s; outside this range it cycles. Gains for {NEAR[0]:g} "
        f"to {NEAR[1]:g} are lower{as_tuned(loop)}.",
        f"{loop.equations}, linearised and sampled",
        objects=masses[0] > CLOSE[0] or masses[1] < CLOSE[1],
    )


def _stable(loop: Loop) -> bool:
    return largest_radius(loop, loop.scenario.clock.control) <= 1 + MARGIN


def _blames_gain(loop: Loop) -> bool:
    """True if a base that takes velocities would be stable with a gain of 1."""
    if not loop.setup.takes_velocity:
        return False
    right = override(loop.scenario, {"base.gain": [1.0, 1.0], "filter.kind": "none"})
    return _stable(loop_of(settle(right, loop.law)))


def _stands(loop: Loop) -> bool:
    """True if the loop is stable for every mass near the believed one."""
    masses = stable_masses(loop, BEYOND_NEAR)
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
