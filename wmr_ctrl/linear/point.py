"""Points to linearise at: on the reference, or where the loop really settles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.linear.blocks import error_law, error_plant, law_loop
from wmr_ctrl.linear.linearise import Floats, column, outputs_at
from wmr_ctrl.model.system import System, values
from wmr_ctrl.scenario import Scenario
from wmr_ctrl.signals import FORCE
from wmr_ctrl.world.references import sample


@dataclass(frozen=True)
class Point:
    """Error e (3) [m, m, rad], v (2), desired velocity (2) and its rate (2), memory, force (2)."""

    e: Floats
    v: Floats
    v_d: Floats
    v_d_dot: Floats
    memory: Floats
    force: Floats

    @property
    def s(self) -> Floats:
        """e and v in one vector (5)."""
        return np.concatenate((self.e, self.v))

    @property
    def law_input(self) -> Floats:
        """What the law is given here."""
        return np.concatenate((self.s, self.v_d, self.v_d_dot))

    @property
    def plant_input(self) -> Floats:
        """What the plant is given here: force, no disturbance, v_d."""
        return np.concatenate((self.force, np.zeros(2), self.v_d))

    def plant_state(self, plant: System) -> Floats:
        """The plant's state here, its drives' lag settled if it has one."""
        return np.concatenate((self.s, self.force[: plant.x.numel() - 5]))


def reference_velocity(scenario: Scenario, t: float) -> tuple[Floats, Floats]:
    """Desired velocity (2) and its rate (2) at time ``t`` [s]."""
    desired = sample(scenario, np.array([t]))[0]
    return desired[3:5], desired[5:7]


def on_reference(scenario: Scenario, law: str, t: float = 0.0) -> Point:
    """The robot exactly on its reference at time ``t`` [s]: e = 0, v = v_d.

    Estimates and weights have their start values; a remembered sample is that of the reference.
    """
    v_d, v_d_dot = reference_velocity(scenario, t)
    return point_at(scenario, law, np.zeros(3), v_d, v_d, v_d_dot)


def point_at(
    scenario: Scenario, law: str, e: Floats, v: Floats, v_d: Floats, v_d_dot: Floats
) -> Point:
    """Any point, with the memory that one sample there leaves; estimates stay at their start."""
    block = error_law(scenario, law)
    u, memory = np.concatenate((e, v, v_d, v_d_dot)), np.array(block.x0)
    if not law_loop(scenario, law).traits.estimates:
        memory, _ = outputs_at(block, u, memory, np.array(block.p0))
    _, force = outputs_at(block, u, memory, np.array(block.p0))
    return Point(e, v, v_d, v_d_dot, memory, force)


def resting_point(scenario: Scenario, law: str, t: float = 0.0) -> Point:
    """The loop's true resting point around its reference, desired velocities held: Newton's method.

    Friction, a wrong model and the leak of the weights are in it.  Memory that has no rest there is
    an error (ArgumentError).
    """
    start = on_reference(scenario, law, t)
    plant, block = error_plant(ideal_drives(scenario)), error_law(scenario, law)
    unknown = np.concatenate((start.s, start.memory))
    rest = _newton(_residual(plant, block, start), unknown)
    s, memory = rest[:5], rest[5:]
    u = np.concatenate((s, start.v_d, start.v_d_dot))
    _, force = outputs_at(block, u, memory, np.array(block.p0))
    return replace(start, e=s[:3], v=s[3:], memory=memory, force=force)


def ideal_drives(scenario: Scenario) -> Scenario:
    """The scenario with ideal drives: at rest a lag changes nothing."""
    return replace(scenario, actuator=replace(scenario.actuator, lag=0.0, delay=0.0))


def _residual(plant: System, law: System, at: Point) -> ca.Function:
    """(s, memory) -> (rate of s, change of memory over a sample), and its gradient."""
    s, memory = ca.SX.sym("s", 5), ca.SX.sym("memory", law.x.numel())
    u = ca.vertcat(s, ca.DM(at.v_d), ca.DM(at.v_d_dot))
    act = law.function("act", [law.update, law.y])
    following, force = act(u, memory, ca.DM(values(law.params)))
    rate = plant.function("rate", [plant.update])(
        ca.vertcat(force, 0, 0, ca.DM(at.v_d)), s, ca.DM(values(plant.params))
    )
    unknown = ca.vertcat(s, memory)
    residual = ca.vertcat(rate, following - memory)
    return ca.Function("residual", [unknown], [residual, ca.jacobian(residual, unknown)])


def _newton(residual: ca.Function, start: Floats, steps: int = 200) -> Floats:
    point = start.copy()
    for _ in range(steps):
        value, gradient = residual(point)
        step = np.linalg.lstsq(np.asarray(gradient), column(value), rcond=None)[0]
        point = point - step * min(1.0, 0.2 / max(1e-300, float(np.abs(step[:5]).max())))
        if np.abs(column(residual(point)[0])).max() < 1e-12:
            return point
    raise ArgumentError(
        f"the loop has no resting point near its reference ({FORCE.name} and friction cannot "
        "balance there); linearise on the reference instead."
    )


def learned_point(scenario: Scenario, law: str) -> Point | None:
    """Where an adaptive law settles with all that it has learned; None if it does not adapt."""
    if not law_loop(scenario, law).traits.estimates:
        return None
    try:
        return resting_point(scenario, law)
    except ArgumentError:
        return on_reference(scenario, law)
