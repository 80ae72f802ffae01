"""The nonlinear sampled loop in error coordinates: the one that the linear loops are compared with.

One control period as a CasADi function: the law's own graph, its force held, Runge-Kutta steps of
the robot seen from its reference.  Runs are noise-free unless a disturbance is given.

Sine sweeps through it lie over the linear Bode plot; how far the linear picture reaches is its
deviation from this loop against amplitude.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import control as ct
import numpy as np

from wmr_ctrl.control.applied import remembered
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.theory.checks.radius import crossing
from wmr_ctrl.theory.checks.sampled_plant import steps_in
from wmr_ctrl.theory.checks.surroundings import surroundings
from wmr_ctrl.theory.linear.linearise import (
    STATES,
    Floats,
    Point,
    law_loop,
    on_reference,
    resting_point,
    unguarded,
)
from wmr_ctrl.theory.linear.state_space import closed_loop, late
from wmr_ctrl.world.scenario import Scenario

LONGEST_STEP = 2e-3
"""Runge-Kutta steps [s] are at most this long where the control period is not a multiple of dt."""
SETTLE, MEASURE = 4, 4
"""Periods that are waited, and then measured, at least."""
LEVELS = (0.01, 0.1, 1.0)
"""Deviations of interest: 1, 10 and 100 %."""
FORWARD, SIDEWAYS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


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
        path, force = (np.array(part).T for part in _repeated(self.step, count)(start, rows.T))
        states = np.ascontiguousarray(np.vstack((start, path[:-1]))[:, :5], dtype=np.float64)
        times = np.asarray(np.arange(count) * self.period, dtype=np.float64)
        return Course(times, states, force, path[-1, self.states :])


@lru_cache(maxsize=16)
def _repeated(step: ca.Function, count: int) -> ca.Function:
    """So many periods, each from where the last one ended."""
    return step.mapaccum("course", count)


def stepper(
    scenario: Scenario,
    law: str,
    point: Point | None = None,
    period: float | None = None,
    memory: str = "learning",
) -> Stepper:
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


def _one_period(scenario: Scenario, law: str, at: Point, period: float, memory: str) -> ca.Function:
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


def sweep(
    loop: Stepper,
    axis: int,
    amplitude: float,
    frequencies: Floats,
    output: int,
    settle: float = 10.0,
) -> tuple[Floats, np.ndarray]:
    """Frequencies [rad/s] as used, and the complex gain of the output's first harmonic.

    Used are those next to ``frequencies`` whose periods are whole numbers of samples.
    A sine of ``amplitude`` [N or N m] disturbs force ``axis`` (0, 1); ``output`` is an index into
    (e1, e2, e3, v1, omega); ``settle`` [s] is waited at least.
    """
    samples = (max(4, round(2 * math.pi / (float(w) * loop.period))) for w in frequencies)
    used = np.array([2 * math.pi / (loop.period * count) for count in samples])
    gains = [_gain(loop, axis, amplitude, float(w), output, settle) for w in used]
    return used, np.array(gains)


def _gain(
    loop: Stepper, axis: int, amplitude: float, w: float, output: int, settle: float
) -> complex:
    samples = round(2 * math.pi / (w * loop.period))
    waited = max(SETTLE, math.ceil(settle / (samples * loop.period))) * samples
    k = np.arange(waited + MEASURE * samples)
    push = np.zeros((len(k), 2))
    push[:, axis] = amplitude * np.sin(2 * math.pi * k / samples)
    course = loop.run(loop.point.s, len(k) * loop.period, push)
    turning = np.exp(-2j * math.pi * k[waited:] / samples)
    first = 2j * np.mean(course.s[waited:, output] * turning)
    return complex(first / amplitude)


def linear_gain(loop: ct.StateSpace, axis: int, frequencies: Floats, output: int) -> np.ndarray:
    """The same gain of a linear sampled loop from `wmr_ctrl.theory.linear.closed_loop`."""
    points = np.exp(1j * np.asarray(frequencies) * loop.dt)
    return np.array([np.atleast_2d(loop(point))[output, axis] for point in points])


@dataclass(frozen=True)
class LoopPair:
    """Linear and nonlinear loop from one resting point, same sampling, same start."""

    point: Point
    nonlinear: Stepper
    linear: ct.StateSpace
    duration: float

    def responses(self, e: Floats) -> tuple[Course, Floats]:
        """Nonlinear run and linear e (N, 3), from the resting point displaced by ``e`` (3)."""
        start = self.point.s + np.concatenate((e, np.zeros(2)))
        course = self.nonlinear.run(start, self.duration)
        return course, self.point.e + self._linear_to_one @ e

    @cached_property
    def _linear_to_one(self) -> Floats:
        """Linear responses (N, 3, 3) of each error to a displacement of each by one."""
        count = round(self.duration / self.nonlinear.period)
        states = np.eye(self.linear.nstates, 3)
        rows = np.empty((count, 3, 3))
        for k in range(count):
            rows[k] = states[:3]
            states = self.linear.A @ states
        return rows

    def deviation(self, e: Floats) -> float:
        """RMS distance of the two positions (e1, e2), over the RMS linear excursion."""
        course, linear = self.responses(np.asarray(e, dtype=float))
        apart = np.linalg.norm((course.e - linear)[:, :2])
        share = float(apart / np.linalg.norm((linear - self.point.e)[:, :2]))
        return share if math.isfinite(share) else math.inf


def loop_pair(
    scenario: Scenario, law: str, duration: float = 20.0, memory: str = "frozen"
) -> LoopPair:
    """Both loops of ``law`` around where it settles, sampled with the scenario's clock."""
    point = resting_point(scenario, law)
    linear = closed_loop(scenario, law, point, scenario.clock.control, memory)
    return LoopPair(point, stepper(scenario, law, point, memory=memory), linear, duration)


def reach(
    given: LoopPair,
    direction: tuple[float, float, float] = FORWARD,
    levels: tuple[float, ...] = LEVELS,
    between: tuple[float, float] = (1e-3, 5.0),
) -> dict[float, float | None]:
    """Smallest amplitude [m] at which the deviation passes each level; None if not up to 5 m."""
    grid = np.geomspace(*between, 38)

    def deviation(amplitude: float) -> float:
        return given.deviation(amplitude * np.array(direction))

    def passing(level: float) -> float | None:
        first = next((k for k, share in enumerate(deviations) if share > level), None)
        if not first:
            return None if first is None else float(grid[0])
        low, high = map(float, grid[first - 1 : first + 1])
        return crossing(lambda a: deviation(a) - level, low, high, 1e-3)

    deviations = [deviation(a) for a in grid]
    return {level: passing(level) for level in levels}
