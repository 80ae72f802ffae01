"""Can the barrier hold the limit against a wrong model?  Its pull is bounded, and fades at v_u1."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import Floats, Loop
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.checks.wording import FORCE_UNITS, SPEEDS, UNITS
from wmr_ctrl.model.dynamics import friction
from wmr_ctrl.scenario import Change, Robot

GRID = 400


@dataclass(frozen=True)
class Phase:
    """The robot's friction from time ``t`` [s] on."""

    t: float
    m: float
    mu: float


def pushed_through(loop: Loop) -> Iterator[Warning]:
    """Yield an axis whose barrier is too weak at the start's v_c0, once per run."""
    if not loop.uses("limits.") or (np.abs(loop.start.v) > loop.scenario.limits.v_u1).any():
        return
    for phase in phases(loop.scenario.robot, loop.scenario.changes):
        if phase.t <= _approach(loop):
            for axis in (0, 1):
                left = least_pull(loop, axis, phase)
                if left <= 0:
                    yield _warning(loop, axis, phase, -left)
                    return


def least_pull(loop: Loop, axis: int, phase: Phase) -> float:
    """Largest force [N] or moment [N m] that slows the axis between v_c1 and v_u1.

    At the v_c0 of the start, held still, with the robot's friction of ``phase``.  Zero or less: the
    velocity is pushed through the limit.
    """
    limits, sign = loop.scenario.limits, np.sign(loop.start.v_c0[axis]) or 1.0
    share = np.linspace(0, 1, GRID + 1)[1:] ** 2
    u1 = limits.v_u1[axis]
    speeds = u1 - (u1 - limits.v_u2[axis]) * share
    return max(-sign * _net(loop, axis, sign * speed, phase) for speed in speeds)


def phases(robot: Robot, changes: tuple[Change, ...]) -> Iterator[Phase]:
    """Yield the robot's friction at the start and from each change on."""
    phase = Phase(0.0, robot.m, robot.mu)
    yield phase
    for change in changes:
        mass = phase.m if change.m is None else change.m
        phase = Phase(change.t, mass, phase.mu if change.mu is None else change.mu)
        yield phase


def drag(robot: Robot, phase: Phase, v: Floats) -> Floats:
    """Friction F1 (2) [N, N m] of the robot in a phase at velocity ``v`` (2)."""
    column = friction(ca.DM(phase.mu), ca.DM(phase.m), ca.DM(robot.g), ca.DM(robot.v_s), ca.DM(v))
    return np.asarray(column).ravel()


def _net(loop: Loop, axis: int, speed: float, phase: Phase) -> float:
    v = np.zeros(2)
    v[axis] = speed
    force = loop.force_towards(v, loop.start.v_c0) - drag(loop.scenario.robot, phase, v)
    return float(force[axis])


def _approach(loop: Loop) -> float:
    """Time [s] to reach the reference at v_u2: only until then the error can saturate the law."""
    return float(np.hypot(*loop.start.e[:2])) / loop.scenario.limits.v_u2[0]


def _warning(loop: Loop, axis: int, phase: Phase, push: float) -> Warning:
    limit, when = loop.scenario.limits.v_u1[axis], f"from {phase.t:g} s on" if phase.t else "at the start"
    return Warning(
        "model",
        f"The barrier of {loop.law} cannot hold |{SPEEDS[axis]}| below {limit:g} {UNITS[axis]} {when}: "
        f"its pull, weak while the error is large, is exceeded by {push:.3g} {FORCE_UNITS[axis]} of "
        "friction that the law compensates and the robot does not have. Start nearer to the reference, "
        "or let model.mu and model.m not overestimate friction.",
        "Eqs. (9), (15)",
    )
