"""Monitor of the velocity at t = 0 and after every plant step."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from tests.oracle.plant import Pair

_DIVERGED = 1e3  # m/s or rad/s
_COUNTS = 1.0 + 1e-12  # less than this share of a limit beyond it is rounding


@dataclass
class Watch:
    """Extremes and events of one run; axes count from 1, times in s."""

    v_u1: Pair
    max_abs_v: list[float] = field(default_factory=lambda: [0.0, 0.0])
    violations: int = 0
    first_violation: tuple[float, int] | None = None
    stopped: tuple[float, int] | None = None
    stop_reason: str = ""

    def see(self, t, state):
        """Record the state at ``t``; True if the run must end here."""
        speed = first, second = abs(state[3]), abs(state[4])
        if not math.isfinite(sum(state)) and not all(map(math.isfinite, state)):
            return self._stop(t, 2 if math.isfinite(state[3]) else 1, "non-finite")
        most = self.max_abs_v
        most[0], most[1] = max(most[0], first), max(most[1], second)
        if first > self.v_u1[0] * _COUNTS or second > self.v_u1[1] * _COUNTS:
            self.violations += 1
            if self.first_violation is None:
                self.first_violation = (t, 1 if first > self.v_u1[0] * _COUNTS else 2)
        if max(speed) >= _DIVERGED:
            return self._stop(t, 1 if speed[0] >= _DIVERGED else 2, "diverged")
        return False

    def _stop(self, t, axis, reason):
        self.stopped, self.stop_reason = (t, axis), reason
        return True

    def numbers(self):
        """The monitor's numbers by name, as plain Python values."""
        seen = {name: value for name, value in vars(self).items() if name != "v_u1"}
        return {**seen, "max_abs_v": tuple(self.max_abs_v)}
