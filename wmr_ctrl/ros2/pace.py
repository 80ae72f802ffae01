"""Which odometry messages are a law's samples, by their stamps: one a period, whatever the jitter.

A sample is the message nearest to the time at which one is due.  That time follows the messages, as
a phase-locked loop of first order does: it neither holds the jitter of the first one against all
that follow, nor runs off from a sender whose clock is not ours.
"""

from __future__ import annotations

from collections import deque
from statistics import median

FOLLOWED = 0.1
"""Share by which the due time follows a sample that was off it.

Samples follow each message of a sender that is faster than the law by less than half of this share;
the law's mean period is never shorter by more.
"""
FEWEST, LOOKED_AT = 5, 9
"""Spacings of messages whose median is what the sender is taken for; before, it is the period."""
BURST = 0.1
"""Share of a period after a sample in which nothing is one."""


class Pace:
    """Chooses samples of a ``period`` [ns] from stamps [ns] that grow."""

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
