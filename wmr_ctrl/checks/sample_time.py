"""Control period against what the gains allow: linear loop, the barrier's kink, first step."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmr_ctrl.checks.first_step import first_speeds
from wmr_ctrl.checks.loop import PERIOD, Floats, Loop
from wmr_ctrl.checks.sampled_loop import SHORTEST, largest_period
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.checks.wording import SPEEDS, UNITS, joined

SAFE = 0.5
"""Share of a stability limit that the remedies propose."""


def sample_time(loop: Loop) -> Iterator[Warning]:
    """Yield what the control period breaks, each with its number."""
    yield from _linear(loop)
    if loop.uses("limits.") and not loop.guarded:
        yield from _kink(loop)
    if loop.scenario.actuator.ideal and (np.abs(loop.start.v) <= loop.scenario.limits.v_u1).all():
        yield from _first_step(loop)


def kink_limits(loop: Loop) -> Floats:
    """Longest period (2) [s] that is stable at the barrier's kink, |v| = v_u2 with v_c0 beyond it.

    There the force pulls towards v_u2 with its full slope, twice that of the linear loop, so a
    period below 2 M1/slope is needed: 2/rho for the model-based law.
    """
    u1, u2 = (np.array(limit) for limit in (loop.scenario.limits.v_u1, loop.scenario.limits.v_u2))
    slope = -loop.slope_towards(u2, u2 + 0.5 / (u1 - u2))
    mass = np.array((loop.scenario.robot.m, loop.scenario.robot.I))
    return np.asarray(2 * mass / np.maximum(slope, 1e-300))


def _linear(loop: Loop) -> Iterator[Warning]:
    period, limit = loop.scenario.clock.control, largest_period(loop)
    if limit < SHORTEST:
        lower = "the drives' lag or its gains" if loop.scenario.actuator.lag else "its gains"
        yield Warning(
            PERIOD,
            f"{loop.law} is unstable around the reference at these gains, whatever clock.control "
            f"is (tried from {SHORTEST:g} s up): lower {lower}.",
            "Eqs. (4), (7), (33)-(35), linearised",
        )
    elif period >= limit:
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is above {limit:.4g} s, the longest period for which "
            f"{loop.law} is stable around the reference at these gains: choose "
            f"{SAFE * limit:.2g} s or less, or lower the gains.",
            "Eqs. (4), (7), (33)-(35), linearised and sampled",
        )


def _kink(loop: Loop) -> Iterator[Warning]:
    period, limits = loop.scenario.clock.control, kink_limits(loop)
    if (period >= limits).any():
        pairs = zip(SPEEDS, limits, strict=True)
        named = joined(f"{limit:.4g} s for {name}" for name, limit in pairs)
        yield Warning(
            PERIOD,
            f"clock.control = {period:g} s is too long for {loop.law} where the barrier sets in, "
            f"at v_u2 (the bounds are {named}): while the error is large the velocity swings about "
            f"v_u2 and may leave the limit. Choose {SAFE * min(limits):.2g} s or less.",
            "Eqs. (9)-(15), kink at v_u2",
        )


def _first_step(loop: Loop) -> Iterator[Warning]:
    period, limits = loop.scenario.clock.control, np.array(loop.scenario.limits.v_u1)
    reached = first_speeds(loop)
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
            "Eqs. (4), (7), one held step",
        )
