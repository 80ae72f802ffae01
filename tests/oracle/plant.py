"""Robot: dynamics (4) on the kinematics (5), one Runge-Kutta step, and the map onto the wheels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, cos, isinf, nan, sin, tanh

from wmr_ctrl.world.scenario import Robot

Pair = tuple[float, float]

_NOT_A_STATE = (nan,) * 5


@dataclass(frozen=True, slots=True)
class Plant:
    """The robot's parameters as they are in one plant step."""

    robot: Robot

    def step(self, state, torque, dt):
        """State after ``dt`` seconds of constant torque, by the classical Runge-Kutta method."""
        bot, (x, y, theta, v1, omega) = self.robot, state
        m, v_s, half = bot.m, bot.v_s, 0.5 * dt
        thrust = (torque[0] + torque[1]) / bot.r
        turned = bot.l * (torque[0] - torque[1]) / bot.r / bot.I
        weight = bot.mu * m * bot.g
        w2, w4 = omega + half * turned, omega + dt * turned
        at2, at3, at4 = theta + half * omega, theta + half * w2, theta + dt * w2
        p1 = (thrust - weight * tanh(v1 / v_s)) / m
        p2 = (thrust - weight * tanh((v2 := v1 + half * p1) / v_s)) / m
        p3 = (thrust - weight * tanh((v3 := v1 + half * p2) / v_s)) / m
        p4 = (thrust - weight * tanh((v4 := v1 + dt * p3) / v_s)) / m
        try:
            dx = -v1 * sin(theta) + 2.0 * (-v2 * sin(at2)) + 2.0 * (-v3 * sin(at3)) - v4 * sin(at4)
            dy = v1 * cos(theta) + 2.0 * (v2 * cos(at2)) + 2.0 * (v3 * cos(at3)) + v4 * cos(at4)
        except ValueError:  # the sine of infinity
            return _NOT_A_STATE
        return (
            x + dt * (dx / 6.0),
            y + dt * (dy / 6.0),
            theta + dt * ((omega + 2.0 * w2 + 2.0 * w2 + w4) / 6.0),
            v1 + dt * ((p1 + 2.0 * p2 + 2.0 * p3 + p4) / 6.0),
            omega + dt * ((turned + 2.0 * turned + 2.0 * turned + turned) / 6.0),
        )


def plants(robot, changes, clock):
    """(first plant step, plant) pairs in order of time, one more after each change."""
    current = robot
    schedule = [(0, Plant(current))]
    for change in changes:
        named = {"m": change.m, "I": change.I, "mu": change.mu}
        current = replace(current, **{k: v for k, v in named.items() if v is not None})
        first = ceil(change.t / clock.plant - 1e-9)
        schedule.append((first, Plant(current)))
    return schedule


def wheel_torques(force, robot):
    """B1^-1 applied to (thrust [N], turning moment [N m]): torques (right, left) [N m]."""
    half = robot.r / 2.0
    return half * (force[0] + force[1] / robot.l), half * (force[0] - force[1] / robot.l)


def limited_force(force, tau_max, robot):
    """Nearest force that the wheels can exert; the thrust has priority over the moment."""
    if isinf(tau_max):
        return force
    most = 2.0 * tau_max / robot.r
    thrust = min(max(force[0], -most), most)
    room = robot.l * (most - abs(thrust))
    return thrust, min(max(force[1], -room), room)
