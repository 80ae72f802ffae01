"""A run of the loop as odometry messages: heading as a quaternion, which rounds it."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from tests.tables import changes
from wmr_ctrl import simulate
from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.core.signals import MEASURED, POSE
from wmr_ctrl.ros2.compiled_system import CompiledSystem
from wmr_ctrl.ros2.drive_law import QUATERNION, heading
from wmr_ctrl.world.effect import Bound, Effect, EffectRole
from wmr_ctrl.world.model.system import Output, System, port
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import load_scenario

THETA = MEASURED[2]
START = 100_000_000_000
"""Stamp [ns] of the first message, late enough for a clock that runs before it."""


def orientation(theta):
    """Quaternion (x, y, z, w) of a robot on the plane, by REP-103."""
    half = (theta + ca.pi / 2) / 2
    return ca.vertcat(0, 0, ca.sin(half), ca.cos(half))


class Message(Section, key="message"):
    """Parameter: whether the law reads the pose as a message carries it."""

    sent: float = quantity(0.0, unit="1", doc="1: it does")


def carried(scenario):
    """Heading as a message carries it."""
    theta = port(THETA)
    seen = heading(orientation(theta.sym), theta.sym)
    return System(
        "message", "odometry message", inputs=(theta,), outputs=(Output(THETA, seen),),
        period=scenario.clock.control,
    )  # fmt: skip


CARRIED = Effect("message", EffectRole.SENSOR, Message, carried, lambda _: Bound())


def encoder():
    """Theta to quaternion, with the bits of the loop."""
    theta = port(POSE[2])
    outputs = (Output(QUATERNION, orientation(theta.sym)),)
    system = System("encode", "orientation", inputs=(theta,), outputs=outputs, period=1.0)
    return CompiledSystem(system, "encode")


def carried_run(changes, law):
    """The run of a law that reads the pose as a message carries it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(EFFECTS.__dict__, "plugins", (CARRIED,))
        return simulate(load_scenario("paper-simulation", {**changes, "message.sent": 1.0}), law)


COMMON = changes("clock.duration = 3.0; disturbance.std = 0.0")
SMALL = """
robot.m = 1.0; robot.I = 0.003; robot.mu = 0.02; robot.r = 0.033; robot.l = 0.08
limits.v_u1 = [0.22, 2.84]; limits.v_u2 = [0.17, 2.2]; initial.pose = [0.0, -0.3, -0.7]
reference.radius = 0.8; reference.rate = 0.2
base.kind = "velocity"; base.tau = [0.1, 0.1]; base.gain = [0.97, 1.03]
filter.tau = [0.06, 0.15]; filter.gain = [0.95, 1.05]; filter.d = [0.005, 0.05]
filter.odometry = [0.005, 0.05]
"""
GOVERNED = """
filter.kind = "governor"; clock.control = 0.05; base.delay = 0.02; filter.delay = [0.01, 0.03]
"""
BASES = {
    "velocity, governor": ("kanayama", changes(SMALL + GOVERNED)),
    "velocity, clip, observer": (
        "prox", changes(f"{SMALL} filter.kind = 'clip'; clock.control = 0.02"),
    ),
    "velocity, governor, observer": ("prox", changes(SMALL + GOVERNED)),
    "efforts, guard": ("mb", changes("guard.enabled = true; disturbance.truncate = 3.0")),
}  # fmt: skip


def messages(run, period):
    """A run's odometry: message (8,) and stamp [ns] of each sample."""
    encode = encoder()
    columns = (run["x"], run["y"], run["theta"], run["v1"], run["omega"])
    for k, (x, y, theta, v, omega) in enumerate(zip(*columns, strict=True)):
        yield (x, y, *encode.look((theta,)), v, omega), START + round(k * period * 1e9)


def sent_by(run):
    """Commands of a run (N, 2): velocities, or torques (right, left)."""
    sent = ("v_command", "omega_command")
    names = sent if sent[0] in run.columns else ("tau_right", "tau_left")
    return np.column_stack([run[name] for name in names])
