"""The start against the velocity limit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.checks.wording import SPEEDS, UNITS, joined


def start(loop: Loop) -> Iterator[Warning]:
    """Yield where the run starts outside or at the limit, and a law that does not look at it."""
    limits = loop.scenario.limits
    promise = "only the guard brings it back" if loop.guarded else "no theorem promises a return"
    for axis, (v, u1) in enumerate(zip(loop.start.v, limits.v_u1, strict=True)):
        named = f"initial.velocity[{axis + 1}] = {v:.9g} {UNITS[axis]}"
        if abs(v) > u1:
            yield Warning(
                "initial.velocity",
                f"{named} is outside limits.v_u1[{axis + 1}] = {u1:g}: the run begins with a "
                f"violation, the barrier is not defined there, and {promise}. Start inside the "
                "limit.",
                "Eq. (15)",
            )
        elif abs(v) > u1 - limits.clip:
            yield Warning(
                "initial.velocity",
                f"{named} is within limits.clip = {limits.clip:g} of limits.v_u1[{axis + 1}] = "
                f"{u1:g}, where the barrier is cut off and nearly powerless. Start further inside.",
                "Eq. (15)",
            )
    if not (loop.guarded or loop.uses("limits.")):
        yield from _blind(loop)


def _blind(loop: Loop) -> Iterator[Warning]:
    limits, asked = np.array(loop.scenario.limits.v_u1), np.abs(loop.start.v_c0)
    axes = np.flatnonzero(asked > limits)
    if axes.size:
        named = joined(
            f"|{SPEEDS[i]}| = {asked[i]:.3g} {UNITS[i]} (limit {limits[i]:g})" for i in axes
        )
        yield Warning(
            "law",
            f"{loop.law} does not know the velocity limit, and at the start the kinematic loop "
            f"asks for {named}: expect violations. Choose a barrier law such as mb or nn, switch "
            "the guard on, or start nearer.",
            "Eq. (7)",
        )
