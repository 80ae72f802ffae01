"""Samples of a flowpipe, and the bounds that it certifies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import Floats

from .blocks import FollowedBlock
from .motion import UNSURE
from .stretch import Stretch

AGAIN = 1.005
"""Factor by which a guess exceeds what it is extrapolated from."""
FASTEST = 1.2
"""Largest extrapolated growth from block to block."""


@dataclass(frozen=True)
class RunBounds:
    """Certified bounds along a motion, by samples.

    ``position``, ``linear`` [m] and ``heading`` [rad] (n): largest deviations in each sample,
    ``linear`` without remainders.  ``share`` (n): use of the most used condition; ``binding`` (n):
    its index.  ``box``: the fast state's rows (n, rows), the state at samples (n + 1, any), command
    and conditions (n, any).
    """

    position: Floats
    linear: Floats
    heading: Floats
    share: Floats
    binding: Floats
    box: tuple[Floats, Floats, Floats]


@dataclass(frozen=True)
class Instant:
    """A block of samples from ``k`` on, whose matrices are valid until ``end``.

    ``held``: each sample represents all samples until ``end``.
    """

    k: int
    end: int
    here: Stretch
    block: FollowedBlock
    held: bool = False

    @property
    def count(self) -> int:
        """Number of samples in the block."""
        return len(self.block.at)

    def most(self, course: Floats) -> Floats:
        """Largest entries of a per-sample array (n, ...) for this block's samples (J, ...)."""
        if not self.held:
            return course[self.k : self.k + self.count]
        most = course[self.k : self.end].max(axis=0)
        return np.broadcast_to(most, (self.count, *most.shape))

    def least(self, course: Floats) -> Floats:
        """Smallest entries of a per-sample array (n, ...) for this block's samples (J, ...)."""
        return -self.most(-course)


@dataclass(frozen=True)
class Guess:
    """Bounds of remainders in J samples: law's force (J, 2), a box (J, n), plant steps (J, nz)."""

    force: Floats
    box: Floats
    left: Floats

    def holds(self, other: Guess) -> bool:
        """True if no size of the other guess is larger, and all are finite."""
        pairs = zip(self.parts, other.parts, strict=True)
        return all(bool(((its <= mine) & np.isfinite(mine)).all()) for mine, its in pairs)

    @property
    def parts(self) -> tuple[Floats, Floats, Floats]:
        """Force, box and plant-step remainders."""
        return self.force, self.box, self.left

    @property
    def weights(self) -> Floats:
        """Weights of a block's generators (J, ...)."""
        return np.hstack([self.force, self.box])

    def going_on(self, before: Guess, count: int) -> Guess:
        """Extrapolate from the previous block to a block of ``count`` samples."""
        parts = []
        for old, part in zip(before.parts, self.parts, strict=True):
            if len(old) == len(part) == count:
                growth = np.clip(part / np.maximum(old, 1e-300), 1.0, FASTEST)
                parts.append(part * growth * AGAIN)
            else:
                parts.append(np.tile(part.max(axis=0) * AGAIN, (count, 1)))
        return Guess(*parts)

    def grown(self, by: float) -> Guess:
        """The guess with all sizes that are not 0 enlarged."""
        return Guess(*(part * by + UNSURE * (part > 0) for part in self.parts))

    def and_more(self, other: Guess) -> Guess:
        """Element-wise maximum with another guess."""
        return Guess(*map(np.maximum, self.parts, other.parts))


class OtherBoxError(ArithmeticError):
    """Secant boxes do not fit; contains a guess of the samples' contributions."""

    def __init__(self, guess: Guess | None = None) -> None:
        super().__init__("a box does not fit")
        self.guess = guess
