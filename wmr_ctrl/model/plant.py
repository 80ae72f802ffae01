"""The plant: Eqs. (1)-(6) as one System, and its Runge-Kutta step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wmr_ctrl.model.dynamics import acceleration, friction, reduced_mass, wheel_to_force
from wmr_ctrl.model.kinematics import pose_rate
from wmr_ctrl.model.parameters import Parameters
from wmr_ctrl.model.system import Output, System, ports, stack
from wmr_ctrl.signals import BODY_FORCE, PATH, PLANT_STATE, PSI, SKID, TORQUE, TORQUE_NOISE, Signal
from wmr_ctrl.symbolic import ca

if TYPE_CHECKING:
    from wmr_ctrl.scenario import Scenario


def plant(scenario: Scenario, *, rolling: tuple[Signal, ...] = ()) -> System:
    """Continuous System: torques, disturbance torques (right, left), force on the body to motion.

    State x, y [m], theta [rad], v1 [m/s], omega [rad/s], and what else ``rolling`` names: PATH, or
    SKID, which rests here.  Parameters are the robot's.
    """
    torque, noise, pushed = ports(TORQUE), ports(TORQUE_NOISE), ports(BODY_FORCE)
    start = (*scenario.initial.pose, *scenario.initial.velocity)
    state, rolled = ports(PLANT_STATE, start), ports(rolling)
    p = Parameters(scenario)
    m, inertia, mu, r, half_track, g, v_s = (
        p.take(f"robot.{name}") for name in ("m", "I", "mu", "r", "l", "g", "v_s")
    )
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
