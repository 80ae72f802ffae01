"""A law that believes a wrong model: how far off it settles."""

from __future__ import annotations

from collections.abc import Iterator

from wmr_ctrl.checks.barrier import Phase, drag, phases, pushed_through
from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.sampled_loop import operating_points
from wmr_ctrl.checks.warning import Warning

NOTABLE = 0.01
"""Velocity error [m/s] from which it is worth a line."""


def wrong_model(loop: Loop) -> Iterator[Warning]:
    """Yield the largest steady error that a friction other than the believed one leaves.

    Laws that estimate make up for it, and are not asked.
    """
    if not loop.uses("model.") or loop.adaptive or any(pushed_through(loop)):
        return
    offset, phase = max(
        ((velocity_error(loop, phase), phase) for phase in phases(loop.scenario)),
        key=lambda pair: abs(pair[0]),
    )
    if abs(offset) >= NOTABLE:
        yield _warning(loop, offset, phase)


def velocity_error(loop: Loop, phase: Phase) -> float:
    """Steady v1 - v_c0[1] [m/s] on the reference: surplus of force over the law's slope there."""
    v_d = max(operating_points(loop.scenario), key=lambda point: float(abs(point[0])))
    surplus = loop.force_towards(v_d, v_d) - drag(loop.scenario.robot, phase, v_d)
    return float(-surplus[0, 0] / loop.slope_towards(v_d, v_d)[0])


def _warning(loop: Loop, offset: float, phase: Phase) -> Warning:
    believed, robot = loop.scenario.believed, loop.scenario.robot
    forces = [mass * mu * robot.g for mass, mu in ((phase.m, phase.mu), (believed.m, believed.mu))]
    ahead = -offset / loop.setup.kinematics.k[0]
    side = "behind" if ahead > 0 else "ahead of"
    when = f"from {phase.t:g} s on" if phase.t else "from the start"
    return Warning(
        "model",
        f"Friction is {forces[0]:.3g} N {when} where {loop.law} believes {forces[1]:.3g} N: its "
        f"theorem asks for the exact model. Expect the robot about {abs(ahead):.2g} m {side} the "
        "reference from then on; nn adapts instead.",
        "Eq. (9), Theorem 1",
    )
