"""ROS time against a clock that never jumps: jumps, and times in which the process stood still."""

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
        """The same for C."""
        return MomentStruct(self.ros, self.steady, self.simulated)


class Clocks:
    """Looks at the time of each callback; ``longest`` [ns] is the pause that is no freeze."""

    def __init__(self, longest: int, struct: ClocksStruct | None = None) -> None:
        """Begin, or look at those that C has."""
        self.struct = struct or ClocksStruct(longest=longest)
        self._see = node_functions()["clocks_see"]

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of happenings, by name, without those that never happened."""
        listed = zip(HAPPENINGS, self.struct.counts, strict=True)
        return {name: count for name, count in listed if count}

    def start(self) -> None:
        """Begin anew: no callback came before."""
        self.struct.begun = 0

    def see(self, now: Moment) -> tuple[str, ...]:
        """Happenings since the last callback: "time-back", "time-forth", "frozen"."""
        return named_happenings(self._see(byref(self.struct), byref(now.struct)))


def named_happenings(bits: int) -> tuple[str, ...]:
    """Bits in words."""
    return tuple(name for k, name in enumerate(HAPPENINGS) if bits >> k & 1)


def longest_pause(timeout: float, period: float) -> int:
    """Pause between callbacks [ns] that is no freeze, for a time-out and a period [s]."""
    return in_ns(max(timeout, 2.5 * period))
