"""The closed loop, one control sample after the other."""

import math
from collections import deque
from dataclasses import replace

import numpy as np

from tests.oracle.actuator import Drives
from tests.oracle.auxiliary import (
    auxiliary_rate,
    auxiliary_velocity,
    reference_rate,
    tracking_error,
)
from tests.oracle.barrier import barrier, clip
from tests.oracle.guard import VelocityGuard
from tests.oracle.kanayama import Kanayama, Pursuit
from tests.oracle.law import Sight
from tests.oracle.mb import ModelBased
from tests.oracle.monitor import Watch
from tests.oracle.nn import NeuralNetwork
from tests.oracle.noise import key_of, torque_noise
from tests.oracle.pid import Pid
from tests.oracle.plant import limited_force, plants, wheel_torques
from tests.oracle.prox import Prox
from tests.oracle.references import reference_of
from tests.oracle.sensing import Sensors
from tests.oracle.smc import Smc
from tests.oracle.smooth import smooth_barrier
from wmr_ctrl.core.signals import LOG_HEAD

REMEMBERED = 10_000
"""Commands that laws are told of at most."""
TWINS = frozenset({"velocity noise", "pose sensor", "torque noise", "push", "delay", "lag"})
"""Effects that are written down here a second time."""


class _Loop:
    """Everything that changes during a run."""

    def __init__(self, scenario, law, gains, kinematics, seed):
        key, clock = key_of(seed), scenario.clock
        self.scenario, self.clock, self.k = scenario, clock, kinematics["k"]
        self.law = LAW_TWINS[law](gains, scenario)
        self.reference = reference_of(scenario.reference)
        self.sensor = Sensors(scenario.sensor, clock, key)
        self.actuator = Drives(scenario.actuator, clock, key)
        told = replace(scenario.actuator, unmodelled_delay=0.0, lag_spread=0.0)
        self.told = Drives(told, clock, key)
        self.applied = (0.0, 0.0)
        self.sent = deque(maxlen=REMEMBERED)
        self.barrier = smooth_barrier if gains.get("barrier") == "smooth" else barrier
        self.tau_max = min(scenario.actuator.tau_max, gains.get("tau_max", math.inf))
        self.guard = VelocityGuard(scenario, self.tau_max)
        self.noise = torque_noise(key, clock.samples, scenario.disturbance)
        self.plants = plants(scenario.robot, scenario.changes, clock)
        self.log = Recorder(self._memory())
        self.watch = Watch(scenario.limits.v_u1)
        self.state = (*scenario.initial.pose, *scenario.initial.velocity)
        self.ended = self.watch.see(0.0, self.state)

    def run(self):
        """All control samples, or those before the run must end."""
        for k in range(self.clock.samples):
            if self.ended:
                break
            self._sample(k)

    def _sample(self, k):
        """One control step: measure, act, log, and run the plant until the next sample."""
        target = self.reference(k * self.clock.control)
        sight = self._look(k, target)
        torque = wheel_torques(self._force(sight), self.scenario.robot)
        self.sent.appendleft(torque)
        right, left = self._disturbance(k)
        self.log.rows.append(self._row(k, target, sight, torque, (right, left)))
        told = []
        for j in range(self.clock.substeps):
            if not self.ended:
                told.append(self.told.advance(torque))
                self._plant_step(k * self.clock.substeps + j, torque, (right, left))
        self.applied = _mean(told)

    def _disturbance(self, k):
        """Noise of sample ``k`` (right, left) [N m], plus a push in each axis' direction of
        motion.
        """
        right, left = self.noise[k].tolist()
        force, moment = self.scenario.disturbance.push
        along = wheel_torques((force, 0.0), self.scenario.robot)[0]
        around = wheel_torques((0.0, moment), self.scenario.robot)[0]
        along = -along if self.state[3] < 0.0 else along
        around = -around if self.state[4] < 0.0 else around
        return right + (along + around), left + (along - around)

    def _force(self, sight):
        """Force that the law demands (thrust [N], moment [N m]), limited by guard and wheels."""
        asked = self.law.act(sight)
        if self.scenario.guard.enabled:
            return self.guard.act(asked, sight.v, sight.applied)
        self.guard.watch(sight.v, sight.applied)
        return limited_force(asked, self.tau_max, self.scenario.robot)

    def _memory(self):
        """Further columns: the law's, then the monitor's."""
        return {**self.law.memory(), **self.guard.seen}

    def _look(self, k, target):
        pose, v = self.sensor.look(k, self.state)
        e = tracking_error(target, pose)
        v_c0 = auxiliary_velocity(e, target, self.k)
        limits = self.scenario.limits
        first, second = (
            self.barrier(clip(v[i], u1 - limits.clip), v_c0[i], u1, limits.v_u2[i])
            for i, u1 in enumerate(limits.v_u1)
        )
        rate = auxiliary_rate(e, v, target, self.k)
        share = reference_rate(e, target, self.k)
        return Sight(
            v, v_c0, rate, (first, second), target, e, pose, self.k, self.applied, share, self.sent
        )  # fmt: skip

    def _plant_step(self, n, torque, noise):
        """The plant's step number ``n`` with the parameters at its start."""
        while len(self.plants) > 1 and self.plants[1][0] <= n:
            self.plants.pop(0)
        acting = self.actuator.advance(torque)
        total = (acting[0] + noise[0], acting[1] + noise[1])
        self.state = self.plants[0][1].step(self.state, total, self.clock.plant)
        self.ended = self.watch.see((n + 1) * self.clock.plant, self.state)

    def _row(self, k, target, sight, torque, noise):
        """The log's row: state at t_k, torques over the step, memory after the law acted."""
        x, y, theta, v1, omega = self.state
        row = {"t": k * self.clock.control, "x": x, "y": y, "theta": theta, "v1": v1}
        row |= {"omega": omega, "psi": theta + math.pi / 2.0}
        row |= target.columns()
        row |= {"tau_right": torque[0], "tau_left": torque[1]}
        row |= {"noise_right": noise[0], "noise_left": noise[1]}
        return row | self._diagnostics(target, sight) | self._memory()

    def _diagnostics(self, target, sight):
        """Error of the true pose; margin and the rest from the law's measurements."""
        speeds = zip(sight.v, self.scenario.limits.v_u1, strict=True)
        first, second = sight.barrier
        return {
            "e": tracking_error(target, self.state[:3]),
            "v_c0": sight.v_c0,
            "v_c1": (first.v_c1, second.v_c1),
            "V1": first.V1 + second.V1,
            "q": (first.q, second.q),
            "margin": min(1.0 - abs(v) / u1 for v, u1 in speeds),
        }


def _mean(pairs):
    count = max(1, len(pairs))
    return sum(pair[0] for pair in pairs) / count, sum(pair[1] for pair in pairs) / count


class Recorder:
    """Collects rows of values by column name; ``further``: columns beyond those of all laws."""

    def __init__(self, further):
        self.sizes = {signal.name: signal.size for signal in LOG_HEAD}
        self.sizes |= {name: len(v) if isinstance(v, tuple) else 1 for name, v in further.items()}
        self.rows = []

    def columns(self):
        """Arrays (N,), or (N, size) for vectors, also when there is no row."""
        return {
            name: np.array([row[name] for row in self.rows], dtype=float).reshape(
                -1 if size == 1 else (-1, size)
            )
            for name, size in self.sizes.items()
        }


LAW_TWINS = {
    "pid": Pid, "smc": Smc, "mb": ModelBased, "nn": NeuralNetwork, "prox": Prox,
    "kanayama": Kanayama, "pursuit": Pursuit,
}  # fmt: skip
