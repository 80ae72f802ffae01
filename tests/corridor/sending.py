"""An adversary of bases that take velocities, with a loop of its own from law to wheels.

The law is Kanayama's, or the model-based law through an inverse first-order lag.  Behind it are
commands in transit, a first-order or PI loop in every plant step, and the oracle's plant.  The
product's filter is between law and base and must not change a command inside the bounds.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import casadi as ca
import numpy as np

from tests.oracle.auxiliary import auxiliary_rate, auxiliary_velocity, tracking_error
from tests.oracle.kanayama import Kanayama
from tests.oracle.law import Sight
from tests.oracle.plant import Plant, wheel_torques
from tests.oracle.references import reference_of
from wmr_ctrl.control.controller import controller
from wmr_ctrl.control.filter.filter import CommandFilter
from wmr_ctrl.control.setup import gains_by_law, settle

TINY = 1e-6
KINDS = ("push", "pose", "velocity", "heard")
OWN = ("kanayama", "mb")
"""Laws that are written down here; of others it is the product's controller that sends."""
FIRST = 2
"""Samples before the first single error: the law's first one knows of no command before."""


@dataclass(frozen=True)
class Course:
    """Errors e at all plant steps (N, 3), velocities sent, and whether the filter changed one."""

    e: np.ndarray
    sent: np.ndarray
    changed: bool

    @property
    def position(self):
        """Largest distance from the place on the path [m]."""
        return float(np.hypot(self.e[:, 0], self.e[:, 1]).max())


class _Base:
    """Speed loop, commands in transit and firmware, initially at the reference's velocity."""

    def __init__(self, scenario, v, idle):
        self.base, self.robot = scenario.base, scenario.robot
        self.h, steps = scenario.clock.plant, round(scenario.base.delay / scenario.clock.plant)
        self.queue = deque([(0.0, 0.0) if idle else v] * steps)
        self.integral = [0.0 if idle else self.friction(v), 0.0]
        self.ramped = [0.0, 0.0] if idle else list(v)

    def friction(self, v):
        return self.robot.mu * self.robot.m * self.robot.g * math.tanh(v[0] / self.robot.v_s)

    def torque(self, sent, v, off):
        self.queue.append(sent)
        u = [self._firmware(i, x + off[i]) for i, x in enumerate(self.queue.popleft())]
        masses = self.robot.m, self.robot.I
        if self.base.loop[0] == "pi":
            force = []
            for i, size in enumerate((1.0, self.robot.l**2)):
                force.append(self.base.kp * size * (u[i] - v[i]) + self.integral[i])
                self.integral[i] += self.h * self.base.ki * size * (u[i] - v[i])
        else:
            force = [
                masses[i] * (self.base.gain[i] * u[i] - v[i])
                * (1 - math.exp(-self.h / self.base.tau[i])) / self.h
                for i in (0, 1)
            ]  # fmt: skip
            force[0] += self.friction(v)
        return wheel_torques(tuple(force), self.robot)

    def _firmware(self, i, u):
        step, dead = self.base.quantum[i], self.base.deadband[i]
        if step > 0:
            u = step * math.floor(u / step + 0.5)
        u, now = 0.0 if abs(u) < dead else u, self.ramped[i]
        if math.isinf(self.base.accel[i]) and math.isinf(self.base.decel[i]):
            return u  # only a ramp stops at 0
        grow, shrink = self.h * self.base.accel[i], self.h * self.base.decel[i]
        up = now + grow if now >= 0 else min(now + shrink, 0.0)
        down = now - grow if now <= 0 else max(now - shrink, 0.0)
        self.ramped[i] = max(down, min(up, u))
        return self.ramped[i]


class _Wish:
    """The law's command and its memory."""

    def __init__(self, scenario, law):
        gains = gains_by_law(scenario)
        self.scenario, self.law, self.gains = scenario, law, gains[law]
        self.k, self.last = gains["kinematics"].k, None

    def asked(self, target, pose, v):
        e = tracking_error(target, pose)
        return self._mb(target, e, v) if self.law == "mb" else self._kanayama(target, e, v)

    def _kanayama(self, target, e, v):
        twin = Kanayama(vars(self.gains), self.scenario)
        twin.command = self.last
        twin.act(Sight(v, (0, 0), (0, 0), (), target, e, (0, 0, 0), self.k))
        return twin.command

    def _mb(self, target, e, v):
        T, tau = self.scenario.clock.control, self.scenario.base.tau
        c, rate = auxiliary_velocity(e, target, self.k), auxiliary_rate(e, v, target, self.k)
        return tuple(
            v[i]
            + T / (1 - math.exp(-T / tau[i])) * (rate[i] - self.gains.rho[i] * (v[i] - c[i]) / 2)
            for i in (0, 1)
        )


class _Sent:
    """Commands of the product's own controller: law, adapter and filter, as exported."""

    def __init__(self, scenario, law, before):
        """``before``: the velocity that was sent until now."""
        system = controller(settle(scenario, law))
        self.step = system.function("sent", [system.update, system.y])
        start = [before if item.signal.name.startswith("v_sent_before") else item.value
                 for item in system.state]  # fmt: skip
        self.x, self.p = ca.DM([x for part in start for x in part]), ca.DM(system.p0)

    def asked(self, target, pose, v):
        u = [target.x, target.y, target.theta, target.v1, target.v2, target.v1_dot, target.v2_dot]
        self.x, y = self.step(ca.DM([*u, *pose, *v]), self.x, self.p)
        return tuple(y.full().ravel().tolist())


def course(scenario, law, samples, *, idle=False, jump=(0.0, 0.0, 0.0), **errors):
    """Course under ``errors`` (samples, 2) of KINDS, from a start moved by ``jump``.

    The kind "heard" is an error of the command that acts, added before the firmware.
    """
    off = {kind: errors.get(kind, np.zeros((samples, 2))) for kind in KINDS}
    reference, clock = reference_of(scenario.reference), scenario.clock
    begin, h = reference(0.0), clock.plant
    base = _Base(scenario, (begin.v1, begin.v2), idle)
    own = law in OWN
    before = (0.0, 0.0) if idle else (begin.v1, begin.v2)
    wish = _Wish(scenario, law) if own else _Sent(scenario, law, before)
    filtered = CommandFilter(scenario) if own and scenario.filter.kind != "none" else None
    turned = begin.theta - jump[2]
    s, c = math.sin(turned), math.cos(turned)
    state = (begin.x + s * jump[0] + c * jump[1], begin.y - c * jump[0] + s * jump[1], turned,
             begin.v1, begin.v2)  # fmt: skip
    share, old, estimate = scenario.sensor.correction, None, None
    rows, sent, changed, n = [], [], False, 0
    plant = Plant(scenario.robot)
    for k in range(samples):
        target, v = reference(k * clock.control), tuple(np.add(state[3:], off["velocity"][k]))
        measured = (state[0] + off["pose"][k, 0], state[1] + off["pose"][k, 1], state[2])
        if share < 1 and estimate is not None:
            theta = estimate[2] + clock.control * old[1]
            way = clock.control * old[0]
            ahead = (
                estimate[0] - way * math.sin(theta),
                estimate[1] + way * math.cos(theta),
                theta,
            )
            measured = tuple(a + share * (m - a) for a, m in zip(ahead, measured, strict=True))
        estimate, old = measured, v
        command = wish.asked(target, measured, v)
        if filtered is not None:
            safe = filtered.step(command, v)
            changed = changed or "limited" in safe.flags
            command = safe.command
        wish.last = command
        sent.append(command)
        for _ in range(clock.substeps):
            torque = base.torque(command, state[3:], off["heard"][k])
            state = plant.step(state, tuple(np.add(torque, off["push"][k])), h)
            n += 1
            rows.append(tracking_error(reference(n * h), state[:3]))
    return Course(np.array(rows), np.array(sent), changed)
