"""Which messages count: in order, of this moment, in the right frame, numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

AHEAD = 0.05
"""A stamp this far in the future [s] is the clock of another machine."""
UNIT = 1e-2
"""How far from 1 the norm of a quaternion may be."""


@dataclass
class Intake:
    """The newest message of a topic that counts, and how many did not, by reason.

    ``frame``: the frame_id that messages must name; "" lets any pass, and a message without one
    passes always.  ``timeout`` [s]: older stamps are refused.
    """

    timeout: float
    frame: str = ""
    value: tuple[float, float] = (0.0, 0.0)
    refused: dict[str, int] = field(default_factory=dict)
    taken: int = 0
    _stamp: float = -math.inf
    _arrived: float = -math.inf
    _late: float = 0.0

    def take(
        self, value: tuple[float, float], stamp: float, frame: str, now: float, steady: float
    ) -> str:
        """Take a message (v [m/s], omega [rad/s]); the reason where it is refused, else "".

        ``stamp`` [s] is its own, 0 where it has none, ``now`` [s] ROS time, ``steady`` [s] a clock
        that never jumps.
        """
        reason = self._objection(value, stamp, frame, now)
        if reason:
            self.refused[reason] = self.refused.get(reason, 0) + 1
            return reason
        self.value, self._arrived = value, steady
        self._late = max(0.0, now - stamp) if stamp else 0.0
        self._stamp = stamp or self._stamp
        self.taken += 1
        return ""

    def _objection(self, value: tuple[float, float], stamp: float, frame: str, now: float) -> str:
        if not all(map(math.isfinite, value)):
            return "not a number"
        if self.frame and frame and frame != self.frame:
            return "wrong frame"
        if not stamp:
            return ""
        if stamp > now + AHEAD:
            return "from the future"
        if now - stamp > self.timeout:
            return "too old"
        return "repeated or out of order" if stamp <= self._stamp else ""

    def age(self, steady: float) -> float:
        """Time since what the message tells [s]; -1 if there is none."""
        return -1.0 if math.isinf(self._arrived) else self._late + steady - self._arrived

    def forget(self) -> None:
        """Begin anew, as after a jump of ROS time."""
        self._stamp = self._arrived = -math.inf


def is_rotation(x: float, y: float, z: float, w: float) -> bool:
    """Whether a quaternion is a rotation, but for rounding; one that is all zeros is none."""
    return abs(math.sqrt(x * x + y * y + z * z + w * w) - 1) < UNIT
