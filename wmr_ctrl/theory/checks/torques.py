"""Torques: of the first sample, of sensor noise and of the reference, and their limits.

These are the wheels' limit, the demand of the motion, and where tyres spin or lift.
"""

import math
from collections.abc import Iterator
from functools import lru_cache

import casadi as ca
import numpy as np

from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.signals import PLANT_STATE, REFERENCE
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.model.dynamics import force_to_wheel, full_thrust
from wmr_ctrl.world.phases import largest_friction, needed_torque
from wmr_ctrl.world.pose_sensor import PoseSensor
from wmr_ctrl.world.references import sample
from wmr_ctrl.world.scenario import Robot, Scenario

from .error_coordinates import Floats
from .loop import Loop
from .warning import as_tuned

KEY = "actuator.tau_max"
GRIP = "grip, docs/physics.md"
INSTANTS = 400
"""Times at which the reference's torques are looked at."""
NOISY, OF_LIMIT = 1.5, 0.1
"""Change of torque from sample to sample by noise alone that is objected to: more than this
multiple of the torque that the motion needs, and than this share of the wheels' limit.  A bound
of the error has in it what does not change from sample to sample, such as a worn wheel's share."""


def largest_force(robot: Robot, most: float) -> Floats:
    """Largest thrust and moment (2) [N, N m], each alone, of wheels with up to ``most`` [N m]."""
    thrust = full_thrust(robot.r, most)
    return np.array((thrust, robot.l * thrust))


@lru_cache(maxsize=256)
def first_torques(setup: Setup) -> tuple[float, float]:
    """Torques (right, left) [N m] that a law commands at t = 0, without noise.

    For a base that takes velocities: the command (v, omega) [m/s, rad/s].
    """
    scenario, system = setup.scenario, controller(setup)
    names = (item.name for item in (*REFERENCE, *PLANT_STATE))
    desired, start = sample(scenario, np.zeros(1))[0], scenario.initial
    known = dict(zip(names, (*desired, *start.pose, *start.velocity), strict=True))
    given = [known.get(name, 0.0) for item in system.inputs for name in item.signal.elements]
    torque = system.function("first", [system.y])(given, system.x0, system.p0)
    right, left = np.asarray(torque).ravel().tolist()
    return right, left


@lru_cache(maxsize=64)
def _reference_torques(scenario: Scenario) -> Floats:
    """Wheel torques (N, 2) [N m] that keep the plane model on the reference."""
    times = np.linspace(0.0, scenario.clock.duration, INSTANTS)
    rows = sample(scenario, times)
    return needed_torque(scenario, times, rows[:, 3:5], rows[:, 5:7])


def reference_torque(scenario: Scenario) -> float:
    """Largest wheel torque [N m] that keeps the plane model on the reference."""
    return float(np.abs(_reference_torques(scenario)).max())


def weak_drives(loop: Loop) -> Iterator[Warning]:
    """Yield a torque limit that friction alone exhausts."""
    scenario, most = loop.scenario, loop.scenario.actuator.tau_max
    thrust, friction = largest_force(scenario.robot, most)[0], largest_friction(scenario)
    if friction >= thrust:
        yield Warning(
            KEY,
            f"{KEY} = {most:g} N m gives at most {thrust:.3g} N of thrust, and friction needs "
            f"{friction:.3g} N: the robot cannot keep moving. Raise it above "
            f"{friction * scenario.robot.r / 2:.3g} N m.",
            "Eq. (4)",
        )


def grip_warnings(setup: Setup) -> tuple[Warning, ...]:
    """Grip warnings for a law on a scenario with the tyres of [body]; none in the plane."""
    tyres, sentences = grip(setup.scenario), list[str]()
    steady = reference_torque(setup.scenario)
    # To a base that takes velocities the law sends no torque: its own loop makes them.
    first = 0.0 if setup.takes_velocity else max(map(abs, first_torques(setup)))
    if first > tyres.spin:
        end = "slide on a rigid body, and throw it forward when they grip again"
        if first > tyres.lift:
            end = f"and above {tyres.lift:.3g} N m the robot turns over on its caster"
        remedy = (
            f"Up to {KEY} = {math.floor(100 * tyres.keep) / 100:g} no wheel slides within "
            "limits.v_u1 (actuator.traction = true keeps to that); --plant mujoco shows a run on "
            "tyres."
            if tyres.keep > 0
            else "At limits.v_u1 no torque is certain to grip: lower the limits or state better "
            "tyres."
        )
        sentences.append(
            f"At its first sample {setup.name} demands {first:.3g} N m of a wheel; the wheels of "
            f"[body] spin from {tyres.spin:.3g} N m on, {end}. {remedy}"
        )
    if steady > tyres.keep:
        sentences.append(
            f"The reference needs up to {steady:.3g} N m at a wheel, and the tyres of [body] are "
            f"certain to transmit {f'only {tyres.keep:.3g} N m' if tyres.keep else 'nothing'} at "
            "limits.v_u1. Ask for a slower or smoother reference."
        )
    return tuple(Warning(KEY, sentence, GRIP) for sentence in sentences)


def noise_gain(loop: Loop) -> Iterator[Warning]:
    """Yield noise of velocity and pose that the law's gains amplify to large wheel torques.

    An error within +-n in every sample has a standard deviation of n/sqrt(3), that of rounding down
    to counts n/sqrt(6); the difference of two samples has sqrt(2) times that.  Each passes through
    the gradient of the law's own graph on the reference; errors of pose and of both velocities add
    up as squares.
    """
    limit = loop.setup.tau_max if math.isfinite(loop.setup.tau_max) else 0.0
    needed, change = _needed(loop.scenario), _change_by_noise(loop)
    if change <= max(NOISY * needed, OF_LIMIT * limit):
        return
    yield Warning(
        f"gains.{loop.law}",
        f"The noise of its sensors, times the gains of {loop.law}, changes the wheel torques by "
        f"about {change:.3g} N m RMS from sample to sample, where the motion needs {needed:.3g} "
        "N m in all: they will chatter. Measure better (finer encoders, a longer encoder.window "
        f"or sensor.velocity_window), or lower the gains{as_tuned(loop)}.",
        f"{loop.equations}, linearised",
    )


def _needed(scenario: Scenario) -> float:
    """RMS wheel torque that the motion itself needs [N m]."""
    return float(np.sqrt(np.mean(_reference_torques(scenario) ** 2)))


@lru_cache(maxsize=64)
def _change_by_noise(loop: Loop) -> float:
    """RMS change of a wheel's torque between samples from sensor noise alone [N m]."""
    scenario, robot = loop.scenario, loop.scenario.robot
    speeds = sample(scenario, np.linspace(0.0, scenario.clock.duration, INSTANTS))[:, 3:5]
    bound = np.array(scenario.limits.v_u2)
    fastest = np.clip(speeds[np.abs(speeds[:, 0]).argmax()], -bound, bound)
    gain = loop.linear(loop.on_reference(fastest), scenario.clock.control).d
    r, half_track = ca.SX(robot.r), ca.SX(robot.l)
    wheels = [force_to_wheel(r, half_track, ca.SX(ca.DM(column))) for column in gain.T]
    torque = np.asarray(ca.evalf(ca.horzcat(*wheels)))
    return math.sqrt(2) * float(np.sqrt(np.mean(np.sum((torque * _noise(loop)) ** 2, axis=1))))


def _noise(loop: Loop) -> Floats:
    """Standard deviations of e (3) and v (2) as a sample shows them [m, m, rad, m/s, rad/s]."""
    sensor, period = loop.scenario.section(PoseSensor), loop.scenario.clock.control
    rare = max(1.0, sensor.pose_period / period)
    pose = sensor.correction * sensor.pose_noise / math.sqrt(3 * rare)
    encoders = any(item.name == "encoder" for item in loop.setup.effects)
    share = 1 / math.sqrt(6 if encoders else 3)
    return np.array((pose, pose, 0.0, *(share * bound for bound in loop.setup.bound.nbar)))
