"""Samples of a passage, and what a passage certifies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.blocks import FollowedBlock
from wmr_ctrl.corridor.stretch import Stretch


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


@dataclass(frozen=True)
class Instant:
    """The samples of a block: their first, the end of those that their matrices are for.

    ``held``: each of them stands for all samples until that end.
    """

    k: int
    end: int
    here: Stretch
    block: FollowedBlock
    held: bool = False

    @property
    def count(self) -> int:
        """Of the samples."""
        return len(self.block.at)

    def most(self, course: Floats) -> Floats:
        """Of a course by samples (n, ...) the numbers of these (J, ...)."""
        if not self.held:
            return course[self.k : self.k + self.count]
        most = course[self.k : self.end].max(axis=0)
        return np.broadcast_to(most, (self.count, *most.shape))


class WiderBoxError(ArithmeticError):
    """A box of secants is left by such sizes; ``place``: 0 of the law's, 1 of the plant step's."""

    def __init__(self, place: int, sizes: Floats) -> None:
        super().__init__("a box is left")
        self.place, self.sizes = place, sizes
