"""The pose that a law sees: late, and filtered by dead reckoning, as part of the linear plant.

Near the reference the pose sensor is a linear filter. Displacements are written in the reference's
own frame, which turns by omega_d T from one sample to the next. A late pose also shifts where the
robot settles (it is behind by what it drove meanwhile); stability is that of the loop on the
reference all the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import casadi as ca
import numpy as np

from wmr_ctrl.checks.lateness import Lateness
from wmr_ctrl.checks.sampled_plant import Floats, SampledPlant
from wmr_ctrl.model.tracking import error_rotation
from wmr_ctrl.world.pose_sensor import reckoned


def with_pose_sensor(
    plant: SampledPlant, v_d: Floats, period: float, late: Lateness, *, comes: bool = True
) -> SampledPlant:
    """The plant whose measured error (3) is that of the pose which its sensor shows.

    ``v_d`` (2) in m/s, rad/s. In this sample a pose ``comes`` or not: one that is
    ``late.pose_age`` old in whole periods, and moves the estimate by ``late.correction`` of the
    difference. The plant itself if poses are neither late nor filtered nor rare.
    """
    age, size = round(late.pose_age / period), len(plant.moved)
    if age == 0 and late.correction == 1.0 and late.samples_a_pose(period) == 1:
        return plant
    share = late.correction if comes else 0.0
    to_error, turned, by_pose, by_velocity = map(np.asarray, _geometry()(v_d, period))
    more = 3 + 3 * age
    whole = np.eye(size + more)
    old = [whole[size + k : size + k + 3] for k in range(0, more, 3)]
    error, velocity = np.vsplit(_wide(plant.measured, more), [3])
    now = np.linalg.solve(to_error, error)
    estimate = (1 - share) * old[0] + share * (old[-1] if age else now)
    following = [by_pose @ estimate + by_velocity @ velocity, now, *old[1:-1]][: 1 + age]
    return SampledPlant(
        np.vstack((_wide(plant.moved, more), *(turned @ rows for rows in following))),
        _tall(plant.forced, more),
        _tall(plant.pushed, more),
        np.vstack((to_error @ estimate, velocity)),
        _wide(plant.applied, more),
        _wide(plant.sent, more),
        (*plant.names, *(f"pose_before[{k}]" for k in range(1, more + 1))),
    )


def cycle(moved: Callable[[bool], Floats], samples: int) -> Floats:
    """Matrix from one pose to the next, so many samples later; not finite where it grows so far.

    ``moved``: that of one sample, by whether a pose comes in it.
    """
    pose = moved(True)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.linalg.matrix_power(moved(False), samples - 1) @ pose if samples > 1 else pose


def radius_a_sample(moved: Callable[[bool], Floats], samples: int) -> float:
    """Spectral radius, per sample, of a loop that gets a pose every so many samples.

    Where the cycle grows beyond all doubles, that of a sample without a pose: hundreds of powers
    of ten on, the one pose in between makes no difference.  Inf for a law that has no derivative
    there.
    """
    whole = cycle(moved, samples)
    if np.isfinite(whole).all():
        return float(np.abs(np.linalg.eigvals(whole)).max()) ** (1 / samples)
    alone = moved(False)
    return float(np.abs(np.linalg.eigvals(alone)).max()) if np.isfinite(alone).all() else math.inf


def _wide(rows: Floats, more: int) -> Floats:
    return np.hstack((rows, np.zeros((len(rows), more))))


def _tall(columns: Floats, more: int) -> Floats:
    return np.vstack((columns, np.zeros((more, columns.shape[1]))))


@cache
def _geometry() -> ca.Function:
    """On the reference, by v_d and the period, all 3 x 3 but the last.

    Displacement of the pose to tracking error; a displacement in the frame a period later; the
    predicted pose by the estimate before, and by the velocity (3 x 2).
    """
    v_d, T = ca.SX.sym("v_d", 2), ca.SX.sym("T")
    q, v, level = ca.SX.sym("q", 3), ca.SX.sym("v", 2), ca.SX.zeros(3)
    slopes = (ca.jacobian(reckoned(q, v, T), by) for by in (q, v))
    on = [ca.substitute(slope, ca.vertcat(q, v), ca.vertcat(level, v_d)) for slope in slopes]
    turned = error_rotation(ca.SX(0)).T @ error_rotation(v_d[1] * T)
    return ca.Function("geometry", [v_d, T], [-error_rotation(ca.SX(0)), turned, *on])
