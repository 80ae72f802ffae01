"""ROS time compared with a monotonic clock: detects jumps and frozen processes."""

from ctypes import byref
from dataclasses import dataclass

from .native import HAPPENINGS, ClocksStruct, MomentStruct, in_ns, node_functions

BACK, FORTH, FROZEN = HAPPENINGS


@dataclass(frozen=True)
class Moment:
    """``ros`` time and the ``steady`` clock [ns], and whether ROS time is simulated."""

    ros: int
    steady: int
    simulated: bool = False

    @property
    def struct(self) -> MomentStruct:
        """This moment as the C struct."""
        return MomentStruct(self.ros, self.steady, self.simulated)


class Clocks:
    """Time check at each callback; ``longest`` [ns]: longest pause not treated as a freeze."""

    def __init__(self, longest: int, struct: ClocksStruct | None = None) -> None:
        """Create clocks, or wrap the C struct."""
        self.struct = struct or ClocksStruct(longest=longest)
        self._see = node_functions()["clocks_see"]

    @property
    def counts(self) -> dict[str, int]:
        """Counts of time faults by name, without zeros."""
        listed = zip(HAPPENINGS, self.struct.counts, strict=True)
        return {name: count for name, count in listed if count}

    def start(self) -> None:
        """Reset: no earlier callback."""
        self.struct.begun = 0

    def see(self, now: Moment) -> tuple[str, ...]:
        """Time faults since the last callback: "time-back", "time-forth", "frozen"."""
        return named_happenings(self._see(byref(self.struct), byref(now.struct)))


def named_happenings(bits: int) -> tuple[str, ...]:
    """Names of the time faults whose bits are set."""
    return tuple(name for k, name in enumerate(HAPPENINGS) if bits >> k & 1)


def longest_pause(timeout: float, period: float) -> int:
    """Longest pause between callbacks [ns] not treated as a freeze; time-out and period in s."""
    return in_ns(max(timeout, 2.5 * period))
