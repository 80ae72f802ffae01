"""Effect of a wrong model on the barrier, whose pull fades at v_u1, and on the error."""

import math
from collections.abc import Iterator

import numpy as np

from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.phases import Phase, drag, full_friction, phases

from .error_coordinates import Floats
from .loop import Loop
from .radius import operating_points
from .torques import largest_force
from .warning import FORCE_UNITS, SPEEDS, UNITS

GRID = 200
NOTABLE = 0.01
"""Velocity error [m/s] from which it is worth a line."""


def pushed_through(loop: Loop) -> Iterator[Warning]:
    """Yield the first phase in which the barrier is too weak for the start's v_c0."""
    outside = (np.abs(loop.start.v) > loop.scenario.limits.v_u1).any()
    if loop.guarded or outside or not loop.has_barrier:
        return
    # The error can saturate the law only until the robot has come near, at v_u2.
    approach = float(np.hypot(*loop.start.e[:2])) / loop.scenario.limits.v_u2[0]
    for phase in phases(loop.scenario):
        axes = np.flatnonzero(largest_pull(loop, phase) <= 0)
        if phase.t <= approach and axes.size:
            yield _warning(loop, int(axes[0]), phase)
            return


def largest_pull(loop: Loop, phase: Phase) -> Floats:
    """Largest force and moment (2) [N, N m] that slow the axes between v_u2 and v_u1.

    For the start's v_c0, held constant, and the robot's friction in ``phase``.  Zero or less: the
    velocity is pushed through the limit.
    """
    limits = loop.scenario.limits
    u1, u2 = (np.array(limit)[:, None] for limit in (limits.v_u1, limits.v_u2))
    sign = np.where(loop.start.v_c0 < 0, -1.0, 1.0)[:, None]
    speeds = sign * (u1 - (u1 - u2) * np.linspace(0, 1, GRID + 1)[1:] ** 2)
    most = largest_force(loop.scenario.robot, loop.setup.tau_max)[:, None]
    asked = np.clip(loop.force_towards(speeds, loop.start.v_c0), -most, most)
    net = asked - drag(phase.robot, speeds)
    return np.asarray((-sign * net).max(axis=1))


def _warning(loop: Loop, axis: int, phase: Phase) -> Warning:
    push = -largest_pull(loop, phase)[axis]
    limit = f"{loop.scenario.limits.v_u1[axis]:g} {UNITS[axis]}"
    when = f"from {phase.t:g} s on" if phase.t else "at the start"
    surplus, remedy = "", ""
    if loop.traits.model:
        surplus = ", because the law compensates friction that the robot does not have"
        remedy = ", or lower model.mu or model.m so that they do not overestimate friction"
    return Warning(
        "model" if loop.traits.model else "law",
        f"The barrier of {loop.law} cannot hold |{SPEEDS[axis]}| below {limit} {when}: while the "
        f"error is large its pull is weak, and falls short by {push:.3g} "
        f"{FORCE_UNITS[axis]}{surplus}. Start nearer to the reference{remedy}.",
        "Eqs. (9), (15)" if loop.traits.theorem == 1 else "Eq. (15)",
    )


def wrong_model(loop: Loop) -> Iterator[Warning]:
    """Yield the largest steady error caused by a friction other than the believed one.

    Laws that estimate or observe compensate it, and are skipped.
    """
    learns = loop.traits.estimates or loop.traits.observer
    asked = loop.traits.model and not learns
    if not asked or any(pushed_through(loop)):
        return
    offset, phase = _largest_error(loop)
    if abs(offset) < NOTABLE:
        return
    forces = [full_friction(robot) for robot in (phase.robot, loop.scenario.believed)]
    exact = ": its theorem asks for the exact model" if loop.traits.theorem else ""
    way = abs(offset) / loop.setup.kinematics.k[0] if loop.traits.auxiliary else math.inf
    side = "behind" if offset < 0 else "ahead of"
    consequence = (
        f"the robot about {way:.2g} m {side} the reference"
        if loop.traits.auxiliary
        else f"a speed that is off by {abs(offset):.2g} m/s"
    )
    yield Warning(
        "model",
        f"Friction is {forces[0]:.3g} N {_from(phase)}, but {loop.law} believes {forces[1]:.3g} "
        f"N{exact}. Expect {consequence} from then on; nn adapts instead.",
        f"Eq. (9), Theorem {loop.traits.theorem}" if loop.traits.theorem else "Eq. (4)",
        objects=way > loop.scenario.metrics.tolerance,
    )


def unmodelled(loop: Loop) -> Iterator[Warning]:
    """Yield the lag caused by friction, for a law that neither models nor learns it."""
    traits, tolerance = loop.traits, loop.scenario.metrics.tolerance
    makes_up = traits.model or traits.estimates or traits.observer
    if makes_up or not traits.auxiliary:
        return
    offset, phase = _largest_error(loop)
    behind = -offset / loop.setup.kinematics.k[0]
    if behind <= tolerance:
        return
    force = full_friction(phase.robot)
    yield Warning(
        loop.setup.kinematic_key,
        f"Friction is {force:.3g} N {_from(phase)}, and {loop.law} has no term that compensates "
        f"it: expect the robot to lag about {behind:.2g} m on the path, more than "
        f"metrics.tolerance = {tolerance:g} m. Raise {loop.setup.kinematic_key}[1] and the gain on "
        f"v1, together by a factor of {behind / tolerance:.2g}, if the loop stays stable; or "
        "choose a law that knows or learns friction.",
        "Eqs. (4), (7)",
    )


def _largest_error(loop: Loop) -> tuple[float, Phase]:
    """The steady error of v1 [m/s] that is largest in size, and its phase."""
    errors = ((velocity_error(loop, phase), phase) for phase in phases(loop.scenario))
    return max(errors, key=lambda pair: abs(pair[0]))


def _from(phase: Phase) -> str:
    return f"from {phase.t:g} s on" if phase.t else "from the start"


def velocity_error(loop: Loop, phase: Phase) -> float:
    """Steady v1 - v_c0[1] [m/s] on the reference: excess force divided by the law's slope there."""
    v_d = max(operating_points(loop.scenario), key=lambda point: float(abs(point[0])))
    surplus = loop.force_towards(v_d, v_d) - drag(phase.robot, v_d)
    return float(-surplus[0, 0] / loop.slope_towards(v_d, v_d)[0])
