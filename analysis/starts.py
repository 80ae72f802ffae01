"""Where runs from many starts end, against the set that V2 certifies.

The Lyapunov function V2 of the kinematic loop certifies a region of attraction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from wmr_ctrl.control.barrier.lyapunov import position_lyapunov
from wmr_ctrl.control.setup import kinematic_gains
from wmr_ctrl.results import Outcome
from wmr_ctrl.simulation.many import tabulated
from wmr_ctrl.simulation.memory import Task
from wmr_ctrl.simulation.runnable import RunnableLoop
from wmr_ctrl.theory.linear.linearise import Floats, reference_velocity
from wmr_ctrl.world.model.kinematics import error_rotation
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Scenario


@dataclass(frozen=True)
class Levels:
    """Levels of V2, Eq. (31), below which convergence is certified while |e3| < pi [m^2].

    ``ideal``: velocity loop at rest, v = v_c0.  ``saturated``: v = v_c1, limits and all.
    """

    ideal: float
    saturated: float


def certified(scenario: Scenario) -> Levels:
    """Both levels: 2/k2, the value at the saddle, and min(2/k2, ((v_u2 - |v2_d|)/(k2 v1_d))^2/2).

    The second keeps |v2_d + k2 v1_d e2| <= v_u2[2], where saturation cannot turn V2' positive; it
    is 0 where v1_d > v_u2[1] or |v2_d| > v_u2[2].
    """
    k2 = kinematic_gains(scenario).k[1]
    v_d, _ = reference_velocity(scenario, 0.0)
    spare = np.array(scenario.limits.v_u2) - np.abs(v_d)
    ideal = 2 / k2
    if (spare < 0).any():
        return Levels(ideal, 0.0)
    return Levels(ideal, min(ideal, 0.5 * (float(spare[1]) / (k2 * abs(float(v_d[0])))) ** 2))


def level(scenario: Scenario, e: Floats) -> Floats:
    """V2 of Eq. (31) [m^2] at errors ``e`` (..., 3)."""
    symbol = ca.SX.sym("e", 3)
    k2 = kinematic_gains(scenario).k[1]
    graph = ca.Function("V2", [symbol], [position_lyapunov(symbol, ca.SX(k2))])
    flat = np.asarray(e, dtype=float).reshape(-1, 3)
    return np.asarray(graph(flat.T)).reshape(np.shape(e)[:-1])


def start_at(scenario: Scenario, e: Floats, v: Floats | None = None) -> Floats:
    """Pose and velocity (5) at t = 0 with tracking error ``e`` (3); v defaults to v_d."""
    wanted = np.asarray(e, dtype=float)
    pose_d = sample(scenario, np.zeros(1))[0, :3]
    theta = pose_d[2] - wanted[2]
    back = np.asarray(ca.evalf(error_rotation(ca.SX(theta)))).T @ wanted
    velocity = reference_velocity(scenario, 0.0)[0] if v is None else np.asarray(v, dtype=float)
    return np.concatenate((pose_d[:2] - back[:2], [theta], velocity))


def converged(endings: list[Ending], within: float = 0.05) -> np.ndarray:
    """Mask of runs that end within ``within`` [m] of the reference, (N,)."""
    return np.array([ending.distance < within for ending in endings])


@dataclass(frozen=True)
class Ending:
    """End of a run: outcome, distance to the reference [m], largest |v1| and |omega|.

    The distance is that at the end of the run; infinite for a run that ended early.
    """

    outcome: Outcome
    distance: float
    max_abs_v: tuple[float, float]


def endings(
    loop: RunnableLoop,
    starts: Iterable[Floats],
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Ending]:
    """Run ``loop``, from `wmr_ctrl.api.compile_loop`, once from each start (5: pose and velocity).

    The same noise (seed 0) acts in all runs.  ``jobs``, ``progress`` and Ctrl-C as in
    `wmr_ctrl.simulation.many.tabulated`.
    """
    rows = [tuple(map(float, start)) for start in starts]
    table = tabulated([Task(loop, 0, row) for row in rows], (), jobs, progress)
    scenario = loop.scenario
    end = sample(scenario, np.array([scenario.clock.duration]))[0, :2]
    gaps = np.hypot(table["final_x"] - end[0], table["final_y"] - end[1])
    gaps[table["stop"] > 0] = np.inf
    columns = (table["outcome"], gaps, table["max_abs_v1"], table["max_abs_v2"])
    return [
        Ending(Outcome(outcome), float(gap), (float(v1), float(omega)))
        for outcome, gap, v1, omega in zip(*columns, strict=True)
    ]
