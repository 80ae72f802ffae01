"""What a law makes of its sensors' noise: torque, by its gains, against what the motion needs."""

from __future__ import annotations

import math
from collections.abc import Iterator

import casadi as ca
import numpy as np

from wmr_ctrl.checks.loop import Loop
from wmr_ctrl.checks.remedies import gains_that_fit
from wmr_ctrl.checks.warning import Warning
from wmr_ctrl.checks.world import Floats
from wmr_ctrl.model.dynamics import force_to_wheel
from wmr_ctrl.world.phases import needed_torque
from wmr_ctrl.world.pose_sensor import PoseSensor
from wmr_ctrl.world.references import sample

NOISY, OF_LIMIT = 1.5, 0.1
"""Change of torque from sample to sample by noise alone that is objected to: more than this
multiple of the torque that the motion needs, and than this share of the wheels' limit.  A bound
of the error has in it what does not change from sample to sample, such as a worn wheel's share."""
INSTANTS = 400
"""Times at which the reference's torques are looked at."""


def noise_gain(loop: Loop) -> Iterator[Warning]:
    """Yield where noise of velocity and pose, times the law's gains, drives the wheels.

    An error within +-n in every sample has a standard deviation of n/sqrt(3), that of rounding down
    to counts n/sqrt(6); two samples differ by sqrt(2) of it.  Each goes through the gradient of the
    law's own graph on the reference; errors of pose and of both velocities add up as squares.
    """
    needed, limit = reference_torque_rms(loop), loop.setup.tau_max
    change = change_by_noise(loop)
    if change <= max(NOISY * needed, OF_LIMIT * limit if math.isfinite(limit) else 0.0):
        return
    yield Warning(
        f"gains.{loop.law}",
        f"The noise of its sensors, times the gains of {loop.law}, changes the wheel torques by "
        f"about {change:.3g} N m RMS from sample to sample, where the motion needs {needed:.3g} "
        "N m in all: they will chatter. Measure better (finer encoders, a longer encoder.window "
        f"or sensor.velocity_window), or lower the gains{gains_that_fit(loop)}.",
        f"{loop.equations}, linearised",
    )


def change_by_noise(loop: Loop) -> float:
    """RMS change of a wheel's torque from sample to sample by sensors' noise alone [N m]."""
    period, robot = loop.scenario.clock.control, loop.scenario.robot
    gain = loop.linear(loop.on_reference(tuple(_moving(loop))), period).d
    r, half_track = ca.SX(robot.r), ca.SX(robot.l)
    wheels = [force_to_wheel(r, half_track, ca.SX(ca.DM(column))) for column in gain.T]
    torque = np.asarray(ca.evalf(ca.horzcat(*wheels)))
    return math.sqrt(2) * float(np.sqrt(np.mean(np.sum((torque * _noise(loop)) ** 2, axis=1))))


def reference_torque_rms(loop: Loop) -> float:
    """RMS of the wheel torques that the reference needs, both wheels and the whole run [N m]."""
    times = np.linspace(0.0, loop.scenario.clock.duration, INSTANTS)
    rows = sample(loop.scenario, times)
    torque = needed_torque(loop.scenario, times, rows[:, 3:5], rows[:, 5:7])
    return float(np.sqrt(np.mean(torque**2)))


def _moving(loop: Loop) -> Floats:
    """A desired velocity (2) [m/s, rad/s] of the reference, the fastest, inside v_u2."""
    times = np.linspace(0.0, loop.scenario.clock.duration, INSTANTS)
    speeds = sample(loop.scenario, times)[:, 3:5]
    bound = np.array(loop.scenario.limits.v_u2)
    return np.asarray(np.clip(speeds[np.abs(speeds[:, 0]).argmax()], -bound, bound))


def _noise(loop: Loop) -> Floats:
    """Standard deviations of e (3) and v (2) as a sample shows them [m, m, rad, m/s, rad/s]."""
    sensor, period = loop.scenario.section(PoseSensor), loop.scenario.clock.control
    rare = max(1.0, sensor.pose_period / period)
    pose = sensor.correction * sensor.pose_noise / math.sqrt(3 * rare)
    encoders = any(item.name == "encoder" for item in loop.setup.effects)
    share = 1 / math.sqrt(6 if encoders else 3)
    return np.array((pose, pose, 0.0, *(share * bound for bound in loop.setup.bound.nbar)))
