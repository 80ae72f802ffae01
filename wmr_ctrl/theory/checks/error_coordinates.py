"""The loop's graphs without law and reference, with their gradients, relative to the reference.

The robot's pose becomes the tracking error, Eq. (8); a remembered pose is given in the frame of its
sample; all else is unchanged.  So a motion of constant velocity has one matrix.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.control.loop import Graphs, PlantlessGraphs
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.signals import DISTURBING, MEASURED
from wmr_ctrl.world.effect import Rate
from wmr_ctrl.world.model.graph import unrounded
from wmr_ctrl.world.model.kinematics import error_rotation, pose_rate, tracking_error
from wmr_ctrl.world.model.system import Port, stack
from wmr_ctrl.world.scenario import Scenario

Floats = NDArray[np.float64]
POSE, SPEED = "m, m, rad", "m/s, rad/s"
"""Units by which the memory of a pose and of a velocity is known."""
ROBOT, COMMAND, HELD = 5, 2, 4
"""Sizes: tracking error with v1 and omega; a command; what disturbs over a sample."""


@dataclass(frozen=True, eq=False)
class World:
    """A scenario's graphs without law and reference, with random numbers 0 and without rounding.

    ``ports``: parameters; ``fast``, ``slow``: states; ``held``: number of held inputs.

    ``shown`` (clock, x, m, p): measured pose and velocity, disturbances, next slow state.
    ``sensed`` (clock, x, m, p, e): their gradient by fast state x and slow state m, in error
    coordinates at e; ``nonlinear`` if it depends on memory other than that of poses and velocities.
    ``step`` (clock, z, theta, u, p, v_d): the fast state z one plant step later; both have the
    tracking error in place of the pose.  ``slopes``: its gradient by z and by the held inputs u.
    ``rates`` and ``rate_slopes``: rates of change of the state and of that gradient, for steps of
    length 0.
    """

    ports: tuple[Port, ...]
    fast: tuple[Port, ...]
    slow: tuple[Port, ...]
    held: int
    shown: ca.Function
    sensed: ca.Function
    nonlinear: bool
    step: ca.Function
    slopes: ca.Function
    rates: ca.Function
    rate_slopes: ca.Function

    @cached_property
    def size(self) -> int:
        """Size of the fast state."""
        return len(self.names)

    @property
    def names(self) -> list[str]:
        """Elements of the fast state."""
        return names_of(self.fast)

    def numbers(self, changed: Mapping[str, float]) -> list[float]:
        """Values of the parameters: the scenario's, except those in ``changed``."""
        listed = ((changed.get(item.signal.name), item.value) for item in self.ports)
        return [n for new, own in listed for n in (own if new is None else (new,))]

    def place(self, name: str) -> int:
        """Index of a parameter's number among all numbers."""
        names = [item.signal.name for item in self.ports for _ in item.value]
        return names.index(name)


def _world(setup: Setup) -> World:
    """Differentiate the graphs of a setup."""
    graphs = PlantlessGraphs(setup)
    moved = _quiet(graphs.plant_step(), graphs.draws(Rate.STEP))
    x, m = (stack(item.sym for item in part) for part in (graphs.fast, graphs.slow))
    shown, sensed, nonlinear = _sense(graphs, x, m)
    u, p, h = graphs.u.sym, graphs.p, graphs.parameters.take("clock.plant")
    z, v_d, theta = ca.SX.sym("z", x.numel()), ca.SX.sym("v_d", 2), ca.SX.sym("theta")
    desired, angle = ca.vertcat(0, 0, theta), theta - z[2]
    pose = desired - error_rotation(angle).T @ z[:3]
    after = ca.substitute(unrounded(moved, ca.vertcat(x, u)), x, ca.vertcat(pose, z[3:]))
    desired = carried(desired, v_d, h)
    step = ca.vertcat(tracking_error(desired, after[:3]), after[3:])
    slopes = ca.densify(ca.jacobian(step, ca.vertcat(z, u)))
    given = [graphs.step.clock.sym, z, theta, u, p, v_d]
    return World(
        graphs.parameters.ports, graphs.fast, graphs.slow, u.numel(), shown, sensed, nonlinear,
        step=ca.Function("step", given, [ca.densify(step)]),
        slopes=ca.Function("slopes", given, [slopes]),
        rates=ca.Function("rates", given, [ca.densify(_slope(step, h))]),
        rate_slopes=ca.Function("rate_slopes", given, [ca.densify(_slope(slopes, h))]),
    )  # fmt: skip


def _sense(graphs: Graphs, x: ca.SX, m: ca.SX) -> tuple[ca.Function, ca.Function, bool]:
    """What a sample reads of the states x and m, its gradient, and whether that is nonlinear."""
    shown = ca.vertcat(graphs.sample.column((*MEASURED, *DISTURBING)), *graphs.sample.following)
    shown = unrounded(_quiet(shown, graphs.draws(Rate.SAMPLE)), every := ca.vertcat(x, m))
    e, T = ca.SX.sym("e", 3), graphs.parameters.take("clock.control")
    slopes, level = ca.jacobian(shown, every), ca.SX.zeros(3)
    own = _pose_slope(e, x[2])
    now, later = (_pose_slope(level, theta) for theta in (x[2], x[2] + T * x[4]))
    before, after = [ca.inv(own), ca.SX.eye(x.numel() - 3)], [own, ca.SX.eye(ROBOT + HELD - 3)]
    for item in graphs.slow:
        other = ca.SX.eye(item.signal.size)
        before.append(ca.inv(now) if item.signal.unit == POSE else other)
        after.append(later if item.signal.unit == POSE else other)
    slopes = ca.diagcat(*after) @ slopes @ ca.diagcat(*before)
    given = [graphs.sample.clock.sym, x, m, graphs.p]
    others = stack(item.sym for item in graphs.slow if item.signal.unit not in (POSE, SPEED))
    nonlinear = bool(others.numel()) and ca.depends_on(slopes, others)
    sensed = ca.Function("sensed", [*given, e], [ca.densify(slopes)])
    return ca.Function("shown", given, [ca.densify(shown)]), sensed, nonlinear


def carried(pose: ca.SX, v: ca.SX, h: ca.SX) -> ca.SX:
    """Pose (3,) after h [s] at a constant velocity (2,), by the plant's Runge-Kutta step."""
    thetas = (pose[2], pose[2] + h / 2 * v[1], pose[2] + h * v[1])
    first, middle, last = (pose_rate(theta, v) for theta in thetas)
    return pose + h / 6 * (first + 4 * middle + last)


def _pose_slope(e: ca.SX, theta: ca.SX) -> ca.SX:
    """Gradient (3, 3) of the tracking error by the pose, at error e and orientation theta."""
    pose, desired = ca.SX.sym("pose", 3), ca.SX.sym("desired", 3)
    at = ca.vertcat(0, 0, theta)
    slope = ca.jacobian(tracking_error(desired, pose), pose)
    placed = ca.vertcat(at, at + error_rotation(theta).T @ e)
    return ca.substitute(slope, ca.vertcat(pose, desired), placed)


def _slope(graph: ca.SX, by: ca.SX) -> ca.SX:
    """Derivative of a matrix by a scalar, at 0."""
    slope = ca.jacobian(ca.vec(ca.densify(graph)), by)
    return ca.reshape(ca.substitute(slope, by, ca.SX(0)), graph.shape)


def _quiet(expr: ca.SX, draws: ca.SX) -> ca.SX:
    return ca.substitute(expr, draws, ca.SX.zeros(draws.shape))


def names_of(ports: tuple[Port, ...]) -> list[str]:
    """Names of a state's elements."""
    return [name for item in ports for name in item.signal.elements]


@lru_cache(maxsize=256)
def world_of(scenario: Scenario) -> World:
    """The World of a scenario, built once."""
    return _world(settle(scenario, next(iter(LAWS))))
