"""Dynamics of the robot, Eqs. (1), (2), (4), its plant as a System, and a Runge-Kutta step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmr_ctrl.core.signals import (
    BODY_FORCE,
    PATH,
    PLANT_STATE,
    PSI,
    SKID,
    TORQUE,
    TORQUE_NOISE,
    Signal,
)
from wmr_ctrl.core.symbolic import ca

from .friction import friction
from .kinematics import pose_rate
from .system import Number, Output, Parameters, System, ports, stack

if TYPE_CHECKING:
    from wmr_ctrl.world.scenario import Scenario

NAMES = ("m", "I", "mu", "r", "l", "g", "v_s")
KEYS = tuple(f"robot.{name}" for name in NAMES)
"""Numbers of the robot."""


def reduced_mass(m: ca.SX, inertia: ca.SX) -> ca.SX:
    """Diagonal of M1 = H' M H: (m, I), Eq. (4)."""
    return ca.vertcat(m, inertia)


def wheel_to_force(r: ca.SX, half_track: ca.SX, tau: ca.SX) -> ca.SX:
    """B1 tau with B1 = (1/r) [[1, 1], [l, -l]]: thrust [N] and moment [N m], Eq. (4)."""
    return ca.vertcat(tau[0] + tau[1], half_track * (tau[0] - tau[1])) / r


def force_to_wheel(r: ca.SX, half_track: ca.SX, force: ca.SX) -> ca.SX:
    """B1^-1 F: torques of the right and left wheel [N m]."""
    share = force[1] / half_track
    return 0.5 * r * ca.vertcat(force[0] + share, force[0] - share)


def full_thrust(r: Number, tau: Number) -> Number:
    """phi = 2 tau/r [N]: thrust F and moment N of torques within tau keep |F| + |N|/l <= phi."""
    return 2 * tau / r


def acceleration(mass: ca.SX, force: ca.SX, friction_force: ca.SX) -> ca.SX:
    """v' = M1^-1 (B1 tau - F1), Eq. (4) with C1 = 0 (centre of mass on the axle's midpoint)."""
    return (force - friction_force) / mass


def plant(scenario: Scenario, *, rolling: tuple[Signal, ...] = ()) -> System:
    """Continuous System: torques, disturbance torques (right, left), force on the body to motion.

    State x, y [m], theta [rad], v1 [m/s], omega [rad/s], and the quantities that ``rolling`` names:
    PATH, or SKID, which is constant here.  Parameters are the robot's.
    """
    torque, noise, pushed = ports(TORQUE), ports(TORQUE_NOISE), ports(BODY_FORCE)
    start = (*scenario.initial.pose, *scenario.initial.velocity)
    state, rolled = ports(PLANT_STATE, start), ports(rolling)
    p = Parameters(scenario)
    m, inertia, mu, r, half_track, g, v_s = map(p.take, KEYS)
    x = stack(item.sym for item in state)
    tau = stack(item.sym for item in torque) + stack(item.sym for item in noise)
    force = wheel_to_force(r, half_track, tau) + stack(item.sym for item in pushed)
    v_dot = acceleration(reduced_mass(m, inertia), force, friction(mu, m, g, v_s, x[3:5]))
    rates = {PATH: x[3], SKID: ca.SX(0)}
    rate = ca.vertcat(pose_rate(x[2], x[3:5]), v_dot, *(rates[item] for item in rolling))
    outputs = tuple(Output(item.signal, item.sym) for item in (*state, *rolled))
    heading = Output(PSI, x[2] + ca.pi / 2)
    return System(
        "plant",
        "wheeled robot",
        inputs=(*torque, *noise, *pushed),
        state=(*state, *rolled),
        params=p.ports,
        update=rate,
        outputs=(*outputs, heading),
    )


def rk4_step(system: System, h: ca.SX) -> ca.SX:
    """State of a continuous System after one classical Runge-Kutta step of h [s], inputs held."""
    rate = system.function("rate", [system.update])
    u, x, p = system.u, system.x, system.p
    k1 = rate(u, x, p)
    k2 = rate(u, x + h / 2 * k1, p)
    k3 = rate(u, x + h / 2 * k2, p)
    k4 = rate(u, x + h * k3, p)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
