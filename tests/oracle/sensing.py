"""Sensors of the law: the pose, dead-reckoned and corrected, and the measured velocity."""

import math

import numpy as np

from tests.oracle.noise import LOST, POSE, VELOCITY, symmetric


class Sensors:
    """Measures one state per control sample, in order."""

    def __init__(self, settings, clock, key):
        self.settings = settings
        self.period = clock.control
        self.every = max(1, round(settings.pose_period / clock.control))
        self.pose_error = settings.pose_noise * symmetric(key, clock.samples, POSE)
        self.velocity_error = np.array(settings.velocity_noise) * symmetric(
            key, clock.samples, VELOCITY
        )
        self.chance = (symmetric(key, clock.samples, LOST)[:, 0] + 1.0) / 2.0
        self.estimate = (0.0, 0.0, 0.0)
        self.v_before = (0.0, 0.0)

    def look(self, k, state):
        """Pose (x, y, theta) and velocity (v1, omega) that the law receives at sample ``k``."""
        right, turn = self.velocity_error[k].tolist()
        velocity = (state[3] + right, state[4] + turn)
        if self.settings.perfect:
            return state[:3], velocity
        if k > 0:
            self._predict()
        if k == 0 or (k % self.every == 0 and self.chance[k] >= self.settings.pose_dropout):
            self._correct(k, state)
        self.v_before = velocity
        return self.estimate, velocity

    def _predict(self):
        """One Euler step with the measured velocity of the previous sample, the angle first."""
        x, y, theta = self.estimate
        v1, omega = self.v_before
        theta += self.period * omega
        x -= self.period * v1 * math.sin(theta)
        y += self.period * v1 * math.cos(theta)
        self.estimate = (x, y, theta)

    def _correct(self, k, state):
        """Correction towards the measured pose, complete at the first sample."""
        gain = self.settings.correction if k > 0 else 1.0
        error_x, error_y = self.pose_error[k].tolist()
        x, y, theta = self.estimate
        self.estimate = (
            x + gain * (state[0] + error_x - x),
            y + gain * (state[1] + error_y - y),
            theta + gain * (state[2] - theta),
        )
