"""Messages that count (in order, recent, in the right frame, finite) and are samples."""

from collections import deque
from ctypes import byref, c_double, c_int64
from statistics import median
from typing import Generic, TypeVar

from wmr_ctrl.results.bag_topics import UNIT

from .clocks import Moment
from .native import IntakeStruct, node_functions, reason_words

Numbers = TypeVar("Numbers", bound=tuple[float, ...])
FOLLOWED = 0.1
"""Share by which the due time follows a sample that was off it.

Samples follow each message of a sender that is faster than the law by less than half of this share;
the law's mean period is never shorter by more.
"""
FEWEST, LOOKED_AT = 5, 9
"""Spacings of messages whose median is what the sender is taken for; before, it is the period."""
BURST = 0.1
"""Share of a period after a sample in which nothing is one."""


class IntakeCounts:
    """Numbers of a topic's messages that counted, and of those that did not, by reason."""

    def __init__(self, struct: IntakeStruct) -> None:
        """Look at what C has."""
        self.struct = struct

    @property
    def taken(self) -> int:
        """Number of those that counted."""
        return int(self.struct.taken)

    @property
    def refused(self) -> dict[str, int]:
        """Number of those that did not, by reason."""
        listed = zip(reason_words(), self.struct.refused, strict=True)
        return {reason: count for reason, count in listed if count}


class Intake(IntakeCounts, Generic[Numbers]):
    """The newest message of a topic that counts, and how many did not.

    ``value``: its numbers, here those of no message.  ``frame``: the frame_id that messages must
    name; "" lets any pass, and one without passes unless ``named``.  ``timeout`` [ns]: older stamps
    are refused.
    """

    def __init__(self, timeout: int, value: Numbers, frame: str = "", named: bool = False) -> None:
        """No message came."""
        super().__init__(IntakeStruct(timeout=timeout))
        self.timeout, self.value = timeout, value
        self._frame, self._named = frame.encode(), named
        self._c = node_functions()

    def take(self, value: Numbers, stamp: int, frame: str, now: Moment) -> str:
        """Take a message; the reason where it is refused, else "".

        ``stamp`` [ns] is its own, 0 where it has none.
        """
        reason = self._c["intake_take"](
            byref(self.struct), c_int64(len(value)), (c_double * len(value))(*value),
            c_int64(fits(self._frame, frame, self._named)), c_int64(stamp), byref(now.struct),
        )  # fmt: skip
        if not reason:
            self.value = value
        return reason_words()[reason]

    def refuse(self, reason: str) -> str:
        """Count a message that is refused; the reason again."""
        self._c["intake_refuse"](byref(self.struct), c_int64(reason_words().index(reason)))
        return reason

    def age(self, now: Moment) -> float:
        """Time since what the message tells [s]; -1 if there is none."""
        return float(self._c["intake_age"](byref(self.struct), byref(now.struct)))

    def forget(self) -> None:
        """Begin anew, as after a jump of ROS time."""
        self._c["intake_forget"](byref(self.struct))


def fits(wanted: bytes, given: str, named: bool) -> int:
    """Whether a frame is the wanted one."""
    return int(node_functions()["frame_fits"](wanted, given.encode(), c_int64(named)))


def is_rotation(x: float, y: float, z: float, w: float) -> bool:
    """Whether a quaternion is a rotation, but for rounding; one that is all zeros is none."""
    return bool(node_functions()["is_rotation"]((c_double * 4)(x, y, z, w), c_double(UNIT)))


class Pace:
    """Selection of a law's samples by the stamps [ns] of messages: one a ``period`` [ns].

    A sample is the message nearest to the time at which one is due.  That time follows the
    messages, as a phase-locked loop of first order does: it neither holds the jitter of the first
    one against all that follow, nor runs off from a sender whose clock is not ours.
    """

    def __init__(self, period: int) -> None:
        """Nothing came."""
        self._period = period
        self.forget()

    def forget(self) -> None:
        """Begin anew, as after a jump of the stamps."""
        self._spacings: deque[int] = deque(maxlen=LOOKED_AT)
        self._before: int | None = None
        self.restart()

    def restart(self) -> None:
        """Make the next message a sample; what is known of the sender stays."""
        self._due: float | None = None
        self._sampled = 0

    def due(self, stamp: int) -> bool:
        """Whether a message is a sample; to be asked for each one."""
        if self._before is not None:
            self._spacings.append(stamp - self._before)
        self._before = stamp
        few = len(self._spacings) < FEWEST
        spacing = float(self._period) if few else min(self._period, median(self._spacings))
        late = 0.0 if self._due is None else min(stamp - self._due, spacing)
        burst = self._due is not None and stamp - self._sampled < BURST * self._period
        if burst or late < -spacing / 2:
            return False
        self._sampled, self._due = stamp, stamp + self._period - (1 - FOLLOWED) * late
        return True
