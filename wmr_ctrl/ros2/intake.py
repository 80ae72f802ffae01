"""Which messages count: in order, of this moment, in the right frame, numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from wmr_ctrl.results.bag_topics import UNIT
from wmr_ctrl.ros2.clocks import NS, Moment

AHEAD = 50_000_000
"""A stamp this far in the future [ns] is the clock of another machine."""
Numbers = TypeVar("Numbers", bound=tuple[float, ...])


@dataclass
class Intake(Generic[Numbers]):
    """The newest message of a topic that counts, and how many did not, by reason.

    ``value``: its numbers, here those of no message.  ``frame``: the frame_id that messages must
    name; "" lets any pass, and one without passes unless ``named``.  ``timeout`` [ns]: older stamps
    are refused.  Simulated time has one clock, which a message may overtake: there a stamp
    may be ahead by the time-out, and a message is new when it arrives.
    """

    timeout: int
    value: Numbers
    frame: str = ""
    named: bool = False
    refused: dict[str, int] = field(default_factory=dict)
    taken: int = 0
    _stamp: int | None = None
    _arrived: int | None = None
    _late: int = 0
    _thawed: bool = False

    def take(self, value: Numbers, stamp: int, frame: str, now: Moment) -> str:
        """Take a message; the reason where it is refused, else "".

        ``stamp`` [ns] is its own, 0 where it has none.
        """
        reason = self._objection(value, stamp, frame, now)
        self._thawed = False
        if reason:
            return self.refuse(reason)
        self.value, self._arrived = value, now.steady
        self._late = max(0, now.ros - stamp) if stamp and not now.simulated else 0
        self._stamp = stamp or self._stamp
        self.taken += 1
        return ""

    def refuse(self, reason: str) -> str:
        """Count a message that is refused; the reason again."""
        self.refused[reason] = self.refused.get(reason, 0) + 1
        return reason

    def _objection(self, value: Numbers, stamp: int, frame: str, now: Moment) -> str:
        if not all(map(math.isfinite, value)):
            return "not a number"
        if self.frame and frame != self.frame and (frame or self.named):
            return "wrong frame"
        if not stamp:
            return "queued while this process stood still" if self._thawed else ""
        if stamp > now.ros + (self.timeout if now.simulated else AHEAD):
            return "from the future"
        if now.ros - stamp > self.timeout:
            return "too old"
        late = self._stamp is not None and stamp <= self._stamp
        return "repeated or out of order" if late else ""

    def age(self, now: Moment) -> float:
        """Time since what the message tells [s]; -1 if there is none."""
        if self._arrived is None:
            return -1.0
        return (self._late + now.steady - self._arrived) * NS

    def forget(self) -> None:
        """Begin anew, as after a jump of ROS time."""
        self._stamp = self._arrived = None

    def thaw(self) -> None:
        """Distrust the next message without a stamp: it may have waited while nothing ran."""
        self._thawed = True


def is_rotation(x: float, y: float, z: float, w: float) -> bool:
    """Whether a quaternion is a rotation, but for rounding; one that is all zeros is none."""
    return abs(math.sqrt(x * x + y * y + z * z + w * w) - 1) < UNIT
