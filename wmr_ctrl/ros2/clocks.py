"""ROS time against a clock that never jumps: jumps, and times in which the process stood still."""

from __future__ import annotations

from dataclasses import dataclass, field

BACK, FORTH, FROZEN = "time-back", "time-forth", "frozen"
NS = 1e-9
"""Second of a nanosecond."""
SLACK = 10_000_000
"""ROS time may go back, or fall behind, by so much [ns] without having jumped."""
JUMP = 500_000_000
"""ROS time that gains so much [ns] on the steady clock has jumped ahead."""


@dataclass(frozen=True)
class Moment:
    """``ros`` time and the ``steady`` clock [ns], and whether ROS time is simulated."""

    ros: int
    steady: int
    simulated: bool = False


@dataclass
class Clocks:
    """Looks at the time of each callback; ``longest`` [ns] is the pause that is no freeze.

    ``counts``: how often each was seen.  Simulated time may run at any rate, so only its leaps of
    more than JUMP between two callbacks are jumps ahead.
    """

    longest: int
    counts: dict[str, int] = field(default_factory=dict)
    _before: Moment | None = None

    def start(self) -> None:
        """Begin anew: no callback came before."""
        self._before = None

    def see(self, now: Moment) -> tuple[str, ...]:
        """What has happened since the last callback: "time-back", "time-forth", "frozen"."""
        before, self._before = self._before, now
        if before is None or before.simulated != now.simulated:
            return ()
        passed, steady = now.ros - before.ros, now.steady - before.steady
        seen = [
            (BACK, passed < -SLACK),
            (FORTH, passed - steady > JUMP),
            (FROZEN, steady > self.longest),
        ]
        happened = tuple(name for name, there in seen if there)
        for name in happened:
            self.counts[name] = self.counts.get(name, 0) + 1
        return happened
