"""Can the barrier hold the limit against a wrong model?  Its pull is bounded, and fades at v_u1."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import Floats, Loop
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.checks.wording import FORCE_UNITS, SPEEDS, UNITS
from wmr_ctrl.model.dynamics import friction
from wmr_ctrl.scenario import Robot, Scenario

GRID = 200


@dataclass(frozen=True)
class Phase:
    """The robot's friction from time ``t`` [s] on."""

    t: float
    m: float
    mu: float


def pushed_through(loop: Loop) -> Iterator[Warning]:
    """Yield the first phase in which the barrier is too weak at the start's v_c0."""
    outside = (np.abs(loop.start.v) > loop.scenario.limits.v_u1).any()
    if loop.guarded or outside or not loop.uses("limits."):
        return
    for phase in phases(loop.scenario):
        axes = np.flatnonzero(largest_pull(loop, phase) <= 0)
        if phase.t <= _approach(loop) and axes.size:
            yield _warning(loop, int(axes[0]), phase)
            return


def largest_pull(loop: Loop, phase: Phase) -> Floats:
    """Largest force and moment (2) [N, N m] that slow the axes between v_u2 and v_u1.

    At the v_c0 of the start, held still, with the robot's friction of ``phase``.  Zero or less: the
    velocity is pushed through the limit.
    """
    limits = loop.scenario.limits
    u1, u2 = (np.array(limit)[:, None] for limit in (limits.v_u1, limits.v_u2))
    sign = np.where(loop.start.v_c0 < 0, -1.0, 1.0)[:, None]
    speeds = sign * (u1 - (u1 - u2) * np.linspace(0, 1, GRID + 1)[1:] ** 2)
    net = loop.force_towards(speeds, loop.start.v_c0) - drag(loop.scenario.robot, phase, speeds)
    return np.asarray((-sign * net).max(axis=1))


def phases(scenario: Scenario) -> Iterator[Phase]:
    """Yield the robot's friction at the start and from each change on."""
    phase = Phase(0.0, scenario.robot.m, scenario.robot.mu)
    yield phase
    for change in scenario.changes:
        mass = phase.m if change.m is None else change.m
        phase = Phase(change.t, mass, phase.mu if change.mu is None else change.mu)
        yield phase


def drag(robot: Robot, phase: Phase, v: Floats) -> Floats:
    """Friction F1 (2, N) [N, N m] of the robot in a phase at velocities ``v`` (2, N)."""
    numbers = (phase.mu, phase.m, robot.g, robot.v_s)
    return np.asarray(_friction()(ca.DM(numbers), v))


@cache
def _friction() -> ca.Function:
    p, v = ca.SX.sym("p", 4), ca.SX.sym("v", 2)
    return ca.Function("friction", [p, v], [friction(p[0], p[1], p[2], p[3], v)])


def _approach(loop: Loop) -> float:
    """Time [s] to reach the reference at v_u2: only until then the error can saturate the law."""
    return float(np.hypot(*loop.start.e[:2])) / loop.scenario.limits.v_u2[0]


def _warning(loop: Loop, axis: int, phase: Phase) -> Warning:
    push = -largest_pull(loop, phase)[axis]
    limit = f"{loop.scenario.limits.v_u1[axis]:g} {UNITS[axis]}"
    when = f"from {phase.t:g} s on" if phase.t else "at the start"
    return Warning(
        "model",
        f"The barrier of {loop.law} cannot hold |{SPEEDS[axis]}| below {limit} {when}: its pull, "
        f"weak while the error is large, is exceeded by {push:.3g} {FORCE_UNITS[axis]} of friction "
        "that the law compensates and the robot does not have. Start nearer to the reference, or "
        "let model.mu and model.m not overestimate friction.",
        "Eqs. (9), (15)",
    )
