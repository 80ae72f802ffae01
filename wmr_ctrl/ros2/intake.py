"""Accept messages that are in order, recent, finite and in the right frame, and choose samples."""

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
    """Numbers of accepted messages of a topic, and of refused ones by reason."""

    def __init__(self, struct: IntakeStruct) -> None:
        """Wrap the C struct."""
        self.struct = struct

    @property
    def taken(self) -> int:
        """Number of accepted messages."""
        return int(self.struct.taken)

    @property
    def refused(self) -> dict[str, int]:
        """Number of refused messages, by reason."""
        listed = zip(reason_words(), self.struct.refused, strict=True)
        return {reason: count for reason, count in listed if count}


class Intake(IntakeCounts, Generic[Numbers]):
    """The newest accepted message of a topic, and the number of refused ones.

    ``value``: its numbers, initially the given ones.  ``frame``: the frame_id that messages must
    have; "" accepts any, and a message without one is accepted unless ``named``.  ``timeout`` [ns]:
    older stamps are refused.
    """

    def __init__(self, timeout: int, value: Numbers, frame: str = "", named: bool = False) -> None:
        """Start without a message."""
        super().__init__(IntakeStruct(timeout=timeout))
        self.timeout, self.value = timeout, value
        self._frame, self._named = frame.encode(), named
        self._c = node_functions()

    def take(self, value: Numbers, stamp: int, frame: str, now: Moment) -> str:
        """Take a message; returns the reason if it is refused, else "".

        ``stamp`` [ns] is its own, 0 if it has none.
        """
        reason = self._c["intake_take"](
            byref(self.struct), c_int64(len(value)), (c_double * len(value))(*value),
            c_int64(fits(self._frame, frame, self._named)), c_int64(stamp), byref(now.struct),
        )  # fmt: skip
        if not reason:
            self.value = value
        return reason_words()[reason]

    def refuse(self, reason: str) -> str:
        """Count a refused message, and return the reason again."""
        self._c["intake_refuse"](byref(self.struct), c_int64(reason_words().index(reason)))
        return reason

    def age(self, now: Moment) -> float:
        """Age of the newest accepted message's data [s]; -1 without a message."""
        return float(self._c["intake_age"](byref(self.struct), byref(now.struct)))

    def forget(self) -> None:
        """Reset, as after a jump of ROS time."""
        self._c["intake_forget"](byref(self.struct))


def fits(wanted: bytes, given: str, named: bool) -> int:
    """True if ``given`` is the wanted frame; "" is accepted unless ``named``."""
    return int(node_functions()["frame_fits"](wanted, given.encode(), c_int64(named)))


def is_rotation(x: float, y: float, z: float, w: float) -> bool:
    """True if a quaternion has unit length up to rounding, and so is a rotation."""
    return bool(node_functions()["is_rotation"]((c_double * 4)(x, y, z, w), c_double(UNIT)))


class Pace:
    """Selection of a law's samples by the stamps [ns] of messages: one a ``period`` [ns].

    A sample is the message nearest to the time at which one is due. That time follows the messages,
    as a phase-locked loop of first order does: the jitter of the first message does not shift all
    later ones, and a sender whose clock drifts from ours is followed.
    """

    def __init__(self, period: int) -> None:
        """Start without a message."""
        self._period = period
        self.forget()

    def forget(self) -> None:
        """Reset, as after a jump of the stamps."""
        self._spacings: deque[int] = deque(maxlen=LOOKED_AT)
        self._before: int | None = None
        self.restart()

    def restart(self) -> None:
        """Make the next message a sample; the learned spacing of the sender's messages is kept."""
        self._due: float | None = None
        self._sampled = 0

    def due(self, stamp: int) -> bool:
        """True if this message is a sample; must be called for each message."""
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
