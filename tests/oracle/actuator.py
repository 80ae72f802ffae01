"""Wheel drives: a delay of whole plant steps, then a first-order lag; without noise."""

import math
from collections import deque

from tests.oracle.noise import LAG, symmetric


class Drives:
    """Converts commanded torques to acting torques, one plant step at a time."""

    def __init__(self, settings, clock, key):
        steps = round((settings.delay + settings.unmodelled_delay) / clock.plant)
        self.waiting = deque([(0.0, 0.0)] * steps)
        self.settings, self.dt, self.every = settings, clock.plant, clock.substeps
        self.spread = settings.lag_spread * symmetric(key, clock.samples, LAG)[:, 0]
        self.acting = (0.0, 0.0)
        self.step = 0

    def _keep(self):
        """Remaining share of the acting torque after the plant step that starts now."""
        if not self.settings.lag:
            return 0.0
        lag = self.settings.lag * (1.0 + float(self.spread[self.step // self.every]))
        return math.exp(-self.dt / lag) if lag > 0.0 else 0.0

    def advance(self, commanded):
        """Torques (right, left) [N m] that act over the plant step that starts now."""
        self.waiting.append(commanded)
        right, left = self.waiting.popleft()
        keep, before, self.acting = self._keep(), self.acting, (right, left)
        self.step += 1
        if keep:
            self.acting = right + keep * (before[0] - right), left + keep * (before[1] - left)
        return self.acting
