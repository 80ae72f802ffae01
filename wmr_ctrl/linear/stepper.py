"""The nonlinear sampled loop in error coordinates: the one that the linear loops are compared with.

One control period as a CasADi function: the law's own graph, its force held, Runge-Kutta steps of
the robot seen from its reference.  Runs are noise-free unless a disturbance is given.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.linear.blocks import (
    by_port,
    error_law,
    error_plant,
    holding,
    with_period,
    with_values,
)
from wmr_ctrl.linear.numbers import Floats
from wmr_ctrl.linear.point import Point, on_reference
from wmr_ctrl.model.plant import rk4_step
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario

LONGEST_STEP = 2e-3
"""Runge-Kutta steps [s] are at most this long where the control period is not a multiple of dt."""


@dataclass(frozen=True)
class Course:
    """A run: time (N,), s = (e, v) (N, 5), force (N, 2), at the control samples.

    ``memory`` (n) is the law's after the last sample.
    """

    t: Floats
    s: Floats
    force: Floats
    memory: Floats

    @property
    def e(self) -> Floats:
        """Tracking error (N, 3) [m, m, rad]."""
        return self.s[:, :3]

    @property
    def v(self) -> Floats:
        """Velocity (N, 2) [m/s, rad/s]."""
        return self.s[:, 3:]


@dataclass(frozen=True)
class Stepper:
    """``law`` on ``scenario`` around ``point``, v_d held: built once, run from many starts.

    ``memory``: "learning" moves weights and estimates, "frozen" keeps those of the point.
    """

    point: Point
    period: float
    step: ca.Function
    states: int
    memory: Floats

    def run(self, s: Floats, duration: float, disturbance: Floats | None = None) -> Course:
        """From ``s`` (5) for ``duration`` [s]; ``disturbance`` (N, 2) or (2,) [N, N m] is held."""
        count = round(duration / self.period)
        push = np.zeros(2) if disturbance is None else np.asarray(disturbance, dtype=float)
        rows = np.broadcast_to(push, (count, 2))
        start = np.concatenate((s, self.point.force[: self.states - 5], self.memory))
        every = self.step.mapaccum("course", count)
        found: tuple[Floats, ...] = tuple(np.array(part).T for part in every(start, rows.T))
        path, force = found
        states = np.ascontiguousarray(np.vstack((start, path[:-1]))[:, :5], dtype=np.float64)
        times = np.asarray(np.arange(count) * self.period, dtype=np.float64)
        return Course(times, states, force, path[-1, self.states :])


def stepper(
    scenario: Scenario,
    law: str,
    point: Point | None = None,
    period: float | None = None,
    memory: str = "learning",
) -> Stepper:
    """A Stepper; ``point`` defaults to the reference at t = 0, ``period`` to the clock's [s]."""
    at = on_reference(scenario, law) if point is None else point
    held = scenario.clock.control if period is None else period
    law_block = error_law(scenario, law)
    acting = with_values(with_period(law_block, held), by_port(law_block, at.memory))
    if memory == "frozen" and Loop(scenario, law).adaptive:
        acting = holding(acting, [item.signal.name for item in acting.state])
    moving = error_plant(scenario)
    step = _one_period(moving, acting, at, held, max(1, round(held / min(LONGEST_STEP, held))))
    return Stepper(at, held, step, moving.x.numel(), np.array(acting.x0))


def _one_period(
    moving: System, acting: System, at: Point, period: float, steps: int
) -> ca.Function:
    state, disturbance = ca.SX.sym("state", moving.x.numel()), ca.SX.sym("disturbance", 2)
    memory = ca.SX.sym("memory", acting.x.numel())
    act = acting.function("act", [acting.update, acting.y])
    known = ca.vertcat(state[:5], ca.DM(at.v_d), ca.DM(at.v_d_dot))
    following, force = act(known, memory, ca.DM(acting.p0))
    small = replace(moving, update=rk4_step(moving, ca.SX(period / steps)))
    advance = small.function("advance", [small.update])
    moved = state
    for _ in range(steps):
        moved = advance(ca.vertcat(force, disturbance, ca.DM(at.v_d)), moved, ca.DM(moving.p0))
    start, after = ca.vertcat(state, memory), ca.vertcat(moved, following)
    return ca.Function("period", [start, disturbance], [after, force])
