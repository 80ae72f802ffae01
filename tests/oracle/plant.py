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

    def rate(self, state: State, torque: Pair) -> State:
        """Time derivative of the state under the wheel torques (right, left) [N m]."""
        _, _, theta, v1, omega = state
        bot = self.robot
        thrust = (torque[0] + torque[1]) / bot.r
        moment = bot.l * (torque[0] - torque[1]) / bot.r
        friction = bot.mu * bot.m * bot.g * math.tanh(v1 / bot.v_s)
        return (
            -v1 * math.sin(theta),
            v1 * math.cos(theta),
            omega,
            (thrust - friction) / bot.m,
            moment / bot.I,
        )

    def step(self, state: State, torque: Pair, dt: float) -> State:
        """State after ``dt`` seconds of constant torque, by the classical Runge-Kutta method."""
        try:
            k1 = self.rate(state, torque)
            k2 = self.rate(_moved(state, k1, 0.5 * dt), torque)
            k3 = self.rate(_moved(state, k2, 0.5 * dt), torque)
            k4 = self.rate(_moved(state, k3, dt), torque)
        except ValueError:  # the sine of infinity
            return _NOT_A_STATE
        mean = [
            (a + 2.0 * b + 2.0 * c + d) / 6.0 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)
        ]
        return _moved(state, mean, dt)


def _moved(state: State, rate: State | list[float], h: float) -> State:
    return (
        state[0] + h * rate[0],
        state[1] + h * rate[1],
        state[2] + h * rate[2],
        state[3] + h * rate[3],
        state[4] + h * rate[4],
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
