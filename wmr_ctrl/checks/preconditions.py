"""What the theorems ask of the reference and of the kinematic gains."""

from __future__ import annotations

from collections.abc import Iterator

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.world.references import reference_bounds

THEOREM = "Theorem 1, Eq. (7)"
STANDSTILL = 1e-9
"""Desired speed [m/s] that counts as none."""


def preconditions(loop: Loop) -> Iterator[Warning]:
    """Yield what of 0 < v1_d < v_u2[1], |v2_d| < v_u2[2], k_2 >= 1 does not hold."""
    slowest, fastest, turning = reference_bounds(loop.scenario)
    if slowest <= STANDSTILL:
        yield _not_moving(slowest)
    yield from _too_fast(loop, fastest)
    yield from _turning_too_fast(loop, turning)
    k2 = loop.setup.kinematics.k[1]
    if k2 < 1:
        yield Warning(
            "gains.kinematics.k",
            f"gains.kinematics.k[2] = {k2:g} is below 1, which the proof of Theorem 1 asks for: "
            "raise it.",
            "Eq. (42)",
        )


def _too_fast(loop: Loop, fastest: float) -> Iterator[Warning]:
    limit, threshold = loop.scenario.limits.v_u1[0], loop.scenario.limits.v_u2[0]
    if fastest < threshold:
        return
    if fastest < limit:
        lag = 1 / (limit - fastest) / loop.setup.kinematics.k[0]
        end = f"the barrier leaves the robot about {lag:.2g} m behind on a straight line"
    else:
        end = "the robot may not drive that fast and falls behind"
    yield Warning(
        "reference",
        f"v1_d of the reference reaches {fastest:.4g} m/s, not below limits.v_u2[1] = "
        f"{threshold:g} m/s (v_u1[1] = {limit:g}): {end}. Ask for a slower reference, or raise "
        "v_u2[1].",
        THEOREM,
    )


def _turning_too_fast(loop: Loop, turning: float) -> Iterator[Warning]:
    limit, threshold = loop.scenario.limits.v_u1[1], loop.scenario.limits.v_u2[1]
    if turning >= threshold:
        yield Warning(
            "reference",
            f"|v2_d| of the reference reaches {turning:.4g} rad/s, not below limits.v_u2[2] = "
            f"{threshold:g} rad/s (v_u1[2] = {limit:g}): the angle e3 falls behind and can wind up "
            "by whole turns. Ask for a slower or wider reference, or raise v_u2[2].",
            THEOREM,
        )


def _not_moving(slowest: float) -> Warning:
    what = (
        f"falls to {slowest:.4g} m/s, that is backwards"
        if slowest < -STANDSTILL
        else "falls to 0, and while it stands still nothing steers the sideways error e2"
    )
    return Warning(
        "reference",
        f"v1_d of the reference {what}: the theorems ask for v1_d > 0 and promise no convergence "
        "otherwise. Ask for a reference that keeps moving forwards.",
        THEOREM,
    )
