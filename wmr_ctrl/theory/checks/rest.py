"""Equilibrium of a law's loop at constant reference velocity: Newton's method on its graphs."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from wmr_ctrl.core.signals import PATH, SKID
from wmr_ctrl.world.model.evaluate import evaluated

from .budget import spend
from .error_coordinates import COMMAND, ROBOT, Floats, World
from .sampled_plant import Point, steps_in

if TYPE_CHECKING:
    from wmr_ctrl.world.scenario import Robot

    from .loop import Loop
    from .surroundings import Surroundings

STEPS = 200
"""Most Newton steps."""
STRIDE = 0.2
"""Largest change of error or velocity in a step [m, rad, m/s, rad/s]."""
LEFT = 1e-12
"""Change from sample to sample that is none."""
COST = 0.4
"""Work of a Newton step, as a share of that for eigenvalues."""


def rest(
    loop: Loop, around: Surroundings, start: Point, period: float, robot: Robot | None = None
) -> Point | None:
    """The equilibrium near ``start`` for a control ``period`` [s]; None if there is none.

    Friction, gains, a wrong model and estimates are included.  Drives deliver their commands
    without delay, and sensors show the present state.
    """
    world = around.worlds(period)[0][1]
    step = period / steps_in(period, loop.scenario.clock.plant)
    numbers = around.numbers(world, period, step, robot)
    given = (start.theta, start.v_d, start.v_d_dot, numbers, loop.parameters(period))
    fast = np.zeros(world.size - ROBOT)
    unknown = np.concatenate((start.s, fast, start.force, start.memory))
    if (solution := newton(_graph(loop, around, world), unknown, given)) is None:
        return None
    s, _, force, memory = np.split(solution, np.cumsum((ROBOT, len(fast), COMMAND)))
    return replace(start, e=s[:3], v=s[3:], force=force, memory=memory)


@lru_cache(maxsize=32)
def _graph(loop: Loop, around: Surroundings, world: World) -> ca.Function:
    """Change of fast state, force and memory over a step and a sample, and its gradient by them."""
    core, z = loop.core, ca.SX.sym("z", world.size)
    force, v_d, rate = (ca.SX.sym(name, COMMAND) for name in ("force", "v_d", "rate"))
    theta, p = ca.SX.sym("theta"), ca.SX.sym("p", world.step.size1_in(4))
    after = world.step(0, z, theta, around.torque(world, force), p, v_d)
    known = ca.repmat(force, len(loop.remembered), 1)
    asked, following = loop.act(z[:ROBOT], v_d, rate, core.x, known, core.p)
    unknown = ca.vertcat(z, force, core.x)
    change = ca.vertcat(after - z, asked - force, following - core.x)
    change[[i for i, name in enumerate(world.names) if name in (PATH.name, SKID.name)]] = 0
    slope = ca.densify(ca.jacobian(change, unknown))
    given = [unknown, theta, v_d, rate, p, core.p]
    return ca.Function("change", given, [ca.densify(change), slope])


def newton(change: ca.Function, start: Floats, given: tuple[ArrayLike, ...] = ()) -> Floats | None:
    """A zero of ``change`` by its first input; the second output is its gradient.  None if no zero
    is found.

    A variable that nothing changes keeps its value, such as the integral of a speed loop with
    base.ki = 0.
    """
    point = start.copy()
    for _ in range(STEPS):
        spend(point.size, COST)
        value, slope = evaluated(change, point, *given)
        if not np.isfinite(value).all() or not np.isfinite(slope).all():
            return None
        if np.abs(value).max() < LEFT:
            return point
        moving = slope.any(axis=1)
        step = np.linalg.lstsq(slope * moving, value.ravel(), rcond=None)[0] * moving
        point = point - step * min(1.0, STRIDE / max(1e-300, float(np.abs(step[:ROBOT]).max())))
    return None
