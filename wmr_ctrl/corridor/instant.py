"""A sample of a passage, what is kept of one, and what a passage certifies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.stretch import Stretch

Kept: TypeAlias = tuple[Floats, Floats, list[Floats], list[Floats], list[int]]
"""Columns, pending box, history, commands and oldest slots before a sample that may be repeated."""


@dataclass(frozen=True)
class RunBounds:
    """Certified bounds along a motion, by samples.

    ``position``, ``linear`` [m] and ``heading`` [rad] (n): the most in each sample, the second
    without what is not linear; ``share`` (n): of the condition that is used most, ``binding`` (n)
    its number.
    """

    position: Floats
    linear: Floats
    heading: Floats
    share: Floats
    binding: Floats


@dataclass
class Instant:
    """A sample: its number in the run and in its chunk, whose matrices and end are given.

    ``held``: it stands for all samples until that end.
    """

    k: int
    at: int
    end: int
    here: Stretch
    held: bool = False

    @property
    def part(self) -> slice:
        """The samples that it stands for."""
        return slice(self.k, self.end if self.held else self.k + 1)


class WiderBoxError(ArithmeticError):
    """A box of secants is left by such sizes; ``place``: 0 of the law's, 1 of the plant step's."""

    def __init__(self, place: int, sizes: Floats) -> None:
        super().__init__("a box is left")
        self.place, self.sizes = place, sizes
