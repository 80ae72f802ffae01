"""Response of the linear loop to a start off the reference, sample by sample.

It also has tools to compare it with runs: poses of such a start, and tracking errors of a run.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np

from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.orientation import outward
from wmr_ctrl.theory.checks.loop import Loop
from wmr_ctrl.world.model.kinematics import error_rotation, tracking_error
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario

from .linearise import Floats, Point, law_loop, learned_point, on_reference, reference_velocity
from .state_space import constant_speed

ERROR = 3
INSTANTS = 100
"""Times at which a loop is linearised where the desired velocity varies."""


def operating_point(scenario: Scenario, law: str) -> Point:
    """The point on the reference at t = 0; for an adaptive law the equilibrium of its learning."""
    return learned_point(scenario, law) or on_reference(scenario, law)


def linear_answer(scenario: Scenario, law: str, at: Point, samples: int) -> Floats:
    """Gradient (samples, 3, 3) of the tracking error by its start value, linearised near ``at``.

    Sampled with the scenario's clock, including drives, sensors and rare poses.  Estimates and
    weights are states.  If the desired velocity varies, the loop is linearised on the reference at
    `INSTANTS` times, with the learned values of ``at``.
    """
    loop, period = law_loop(scenario, law), scenario.clock.control
    every, first = loop.around.samples_a_pose(period), _matrix(loop, at, period, 0)
    varies = not constant_speed(scenario)
    points, matrices = {0: at}, dict[tuple[int, int], Floats]()
    state, rows = np.eye(len(first), ERROR), np.empty((samples, ERROR, ERROR))
    stretch = max(1, samples // INSTANTS)
    for k in range(samples):
        rows[k], part = state[:ERROR], k // stretch if varies else 0
        if part not in points:
            there = on_reference(scenario, law, (part + 0.5) * stretch * period)
            points[part] = replace(there, memory=at.memory) if loop.traits.estimates else there
        key = part, every + k % every
        if key not in matrices:
            matrices[key] = _matrix(loop, points[part], period, key[1])
        state = (matrices[key] if k else first) @ state
    return rows


def _matrix(loop: Loop, at: Point, period: float, place: int) -> Floats:
    """Matrix from one sample to the next; the first pose sets all pose estimates."""
    return loop.closed(at, period, sample=place, law=loop.linear(at, period, learning=True))


@checks_arguments
def start_off(
    scenario: Scenario, e: Sequence[float] | Floats, v: Sequence[float] | Floats | None = None
) -> Floats:
    """Pose and velocity (5) at t = 0 with tracking error ``e`` (3) [m, m, rad], for `starts`.

    ``v`` (2) [m/s, rad/s] defaults to the desired velocity.
    """
    pose = _placed(sample(scenario, np.zeros(1))[0, :ERROR], np.asarray(e, dtype=float))
    pose[2] = outward(float(pose[2]), scenario.frames)
    own = reference_velocity(scenario, 0.0)[0] if v is None else np.asarray(v, dtype=float)
    return np.concatenate((pose, own))


def _placed(desired: Floats, e: Floats) -> Floats:
    """Pose (3) with tracking error ``e`` relative to a desired pose: inverse of Eq. (8)."""
    return desired - np.asarray(ca.evalf(error_rotation(ca.SX(desired[2] - e[2])))).T @ e


def tracking_errors(desired: Floats, poses: Floats) -> Floats:
    """Tracking error (N, 3) [m, m, rad], Eq. (8), of poses by desired ones (N, 3), paper frames."""
    return np.asarray(_errors()(desired.T, poses.T), dtype=float).T


@cache
def _errors() -> ca.Function:
    desired, pose = ca.SX.sym("desired", ERROR), ca.SX.sym("pose", ERROR)
    return ca.Function("e", [desired, pose], [tracking_error(desired, pose)])


def moved_along(pose: Floats, start: Floats, end: Floats) -> Floats:
    """Pose (3) relative to ``start`` as ``pose`` is to ``end``, in the paper's frames."""
    return _placed(start, tracking_errors(end[None], pose[None])[0])
