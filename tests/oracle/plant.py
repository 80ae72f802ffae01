"""Robot: dynamics (4) on the kinematics (5), one Runge-Kutta step, and the map onto the wheels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from wmr_ctrl.scenario import Change, Robot
from wmr_ctrl.scenario.sections import Clock

State = tuple[float, float, float, float, float]
"""x [m], y [m], theta [rad], v1 [m/s], omega [rad/s]."""
Pair = tuple[float, float]

_NOT_A_STATE: State = (math.nan,) * 5


@dataclass(frozen=True, slots=True)
class Plant:
    """The robot's parameters as they are in one plant step."""

    robot: Robot

    def step(self, state: State, torque: Pair, dt: float) -> State:
        """State after ``dt`` seconds of constant torque, by the classical Runge-Kutta method."""
        bot, (x, y, theta, v1, omega) = self.robot, state
        thrust = (torque[0] + torque[1]) / bot.r
        turned = bot.l * (torque[0] - torque[1]) / bot.r / bot.I
        weight = bot.mu * bot.m * bot.g
        rates, at, v, w = [], theta, v1, omega
        try:
            for h in (0.5 * dt, 0.5 * dt, dt, 0.0):
                pushed = (thrust - weight * math.tanh(v / bot.v_s)) / bot.m
                rates.append((-v * math.sin(at), v * math.cos(at), w, pushed, turned))
                at, v, w = theta + h * w, v1 + h * pushed, omega + h * turned
        except ValueError:  # the sine of infinity
            return _NOT_A_STATE
        mean = [(a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(*rates, strict=True)]
        return (
            x + dt * mean[0],
            y + dt * mean[1],
            theta + dt * mean[2],
            v1 + dt * mean[3],
            omega + dt * mean[4],
        )


def plants(robot: Robot, changes: tuple[Change, ...], clock: Clock) -> list[tuple[int, Plant]]:
    """(first plant step, plant) pairs in order of time, one more after each change."""
    current = robot
    schedule = [(0, Plant(current))]
    for change in changes:
        named = {"m": change.m, "I": change.I, "mu": change.mu}
        current = replace(current, **{k: v for k, v in named.items() if v is not None})
        first = math.ceil(change.t / clock.plant - 1e-9)
        schedule.append((first, Plant(current)))
    return schedule


def wheel_torques(force: Pair, robot: Robot) -> Pair:
    """B1^-1 applied to (thrust [N], turning moment [N m]): torques (right, left) [N m]."""
    half = robot.r / 2.0
    return half * (force[0] + force[1] / robot.l), half * (force[0] - force[1] / robot.l)


def limited_force(force: Pair, tau_max: float, robot: Robot) -> Pair:
    """Nearest force that the wheels can give, the thrust served first and the moment after it."""
    if math.isinf(tau_max):
        return force
    most = 2.0 * tau_max / robot.r
    thrust = min(max(force[0], -most), most)
    room = robot.l * (most - abs(thrust))
    return thrust, min(max(force[1], -room), room)
