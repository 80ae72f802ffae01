"""Wheel drives: a delay of whole plant steps, then a first-order lag; no noise in here."""

from __future__ import annotations

import math
from collections import deque

from wmr_ctrl.scenario import Actuator
from wmr_ctrl.sim.oracle.plant import Pair


class Drives:
    """Turns the commanded torques into those that act, one plant step at a time."""

    def __init__(self, settings: Actuator, dt: float) -> None:
        steps = round(settings.delay / dt)
        self.waiting: deque[Pair] = deque([(0.0, 0.0)] * steps)
        self.keep = math.exp(-dt / settings.lag) if settings.lag > 0.0 else 0.0
        self.acting: Pair = (0.0, 0.0)

    def advance(self, commanded: Pair) -> Pair:
        """Torques (right, left) [N m] that act over the plant step that starts now."""
        self.waiting.append(commanded)
        right, left = self.waiting.popleft()
        self.acting = (
            right + self.keep * (self.acting[0] - right),
            left + self.keep * (self.acting[1] - left),
        )
        return self.acting
