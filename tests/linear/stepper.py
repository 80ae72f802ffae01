"""The nonlinear sampled loop in error coordinates, with any period and memory, by CasADi."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from wmr_ctrl.control.applied import remembered
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.theory.checks.sampled_plant import steps_in
from wmr_ctrl.theory.checks.surroundings import surroundings
from wmr_ctrl.theory.linear.linearise import (
    STATES,
    Floats,
    Point,
    law_loop,
    on_reference,
    unguarded,
)
from wmr_ctrl.theory.linear.state_space import late

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
    def e(self):
        """Tracking error (N, 3) [m, m, rad]."""
        return self.s[:, :3]

    @property
    def v(self):
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

    def run(self, s, duration, disturbance=None):
        """From ``s`` (5) for ``duration`` [s]; ``disturbance`` (N, 2) or (2,) [N, N m] is held."""
        count = round(duration / self.period)
        push = np.zeros(2) if disturbance is None else np.asarray(disturbance, dtype=float)
        rows = np.broadcast_to(push, (count, 2))
        start = np.concatenate((s, self.point.force[: self.states - 5], self.memory))
        path, force = (np.array(part).T for part in _repeated(self.step, count)(start, rows.T))
        states = np.ascontiguousarray(np.vstack((start, path[:-1]))[:, :5], dtype=np.float64)
        times = np.asarray(np.arange(count) * self.period, dtype=np.float64)
        return Course(times, states, force, path[-1, self.states :])


@lru_cache(maxsize=16)
def _repeated(step, count):
    """So many periods, each from where the last one ended."""
    return step.mapaccum("course", count)


def stepper(scenario, law, point=None, period=None, memory="learning"):
    """A Stepper; ``point`` defaults to the reference at t = 0, ``period`` to the clock's [s].

    Raises ArgumentError where drives or sensors are late by more than a lag.
    """
    if late(scenario):
        raise ArgumentError(
            "the nonlinear loop in error coordinates has no delay and no late sensor: set "
            "actuator.delay and the like to 0 there, or take wmr_ctrl.simulate."
        )
    at = on_reference(scenario, law) if point is None else point
    held = scenario.clock.control if period is None else period
    step = _one_period(scenario, law, at, held, memory)
    asks = bool(remembered(law_loop(scenario, law).over(0).core))
    memory_of = np.concatenate((at.memory, at.force[: 2 * asks]))
    return Stepper(at, held, step, step.size1_in(0) - len(memory_of), memory_of)


def _one_period(scenario, law, at, period, memory):
    """The law, then plant steps, from a state and a disturbance (2) to the next, and the force.

    The state: robot and drives, the law's memory, and the force before where the law asks for it.
    """
    loop, around = law_loop(scenario, law).over(0), surroundings(unguarded(scenario))
    z = ca.SX.sym("z", len(STATES) + 2 * (scenario.actuator.lag > 0))
    own = ca.SX.sym("memory", len(at.memory))
    push, before = ca.SX.sym("push", 2), ca.SX.sym("before", 2 * bool(remembered(loop.core)))
    numbers, desired = ca.DM(loop.parameters(period)), (ca.DM(at.v_d), ca.DM(at.v_d_dot))
    force, following = loop.act(z[:5], *desired, own, before, numbers)
    if memory == "frozen" and loop.traits.estimates:
        following = own
    steps, moved = steps_in(period, min(LONGEST_STEP, period)), z
    for _ in range(steps):
        moved = around.step(moved, force, at.v_d, period / steps, push)
    start = ca.vertcat(z, own, before)
    after = ca.vertcat(moved, following, force[: before.numel()])
    return ca.Function("period", [start, push], [after, force])
