"""Columns of what disturbed each of the last samples, carried along by the loop's matrices."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.checks.world import COMMAND, Floats
from wmr_ctrl.corridor.loop import UP

SINGLE, FAINT = 2.0**-24, 1e-30
"""Share by which a single-precision result errs, and a size that it may take for 0."""
Reals: TypeAlias = NDArray[np.floating]
BLOCK = 2**18
"""Products of numbers below which OpenBLAS takes one thread."""


@dataclass
class Kind:
    """So many columns in each of ``count`` slots from ``first`` on; the oldest slot is ``slot``."""

    first: int
    count: int
    each: int
    slot: int = field(default=0)

    @property
    def end(self) -> int:
        """The column after its last one."""
        return self.first + self.count * self.each

    def next(self) -> slice:
        """Columns of the oldest slot, which becomes the newest."""
        begin = self.first + self.slot * self.each
        self.slot = (self.slot + 1) % self.count
        return slice(begin, begin + self.each)


class CarriedColumns:
    """The columns of all kinds as one matrix of doubles.

    ``known``: of what disturbs, ``added``: of the law's force, ``boxes``: of the components
    ``lasting``, ``misled``: pairs of a disc.
    """

    def __init__(self, lasting: list[int], n: int, held: int, widths: tuple[int, int]) -> None:
        """Of the last ``held`` samples; ``widths``: of ``known`` and of ``misled``."""
        self.lasting = lasting
        self.known = Kind(0, held, widths[0])
        self.added = Kind(self.known.end, held, COMMAND)
        self.boxes = Kind(self.added.end, held, len(lasting))
        self.misled = Kind(self.boxes.end, held, widths[1])
        self.values = np.zeros((n, self.misled.end))
        self._next = np.zeros_like(self.values)
        self._single = np.zeros(self.values.shape, dtype=np.float32)

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """All of them."""
        return self.known, self.added, self.boxes, self.misled

    def carry(self, A: Floats) -> None:
        """Multiply all."""
        _product(A, self.values, self._next)
        self.values, self._next = self._next, self.values

    def replace(self, kind: Kind, new: Floats | float) -> Floats:
        """Put the newest in the place of the oldest; returns the sizes (n) that these had."""
        place = kind.next()
        old: Floats = np.abs(self.values[:, place]).sum(axis=1)
        self.values[:, place] = new
        return old

    def boxed(self, box: Floats) -> Floats:
        """Make the newest boxes of the lasting components of a box (n); returns the rest."""
        newest = self.boxes.first + (self.boxes.slot - 1) % self.boxes.count * self.boxes.each
        places = newest + np.arange(self.boxes.each)
        self.values[self.lasting, places] = box[self.lasting]
        rest = box.copy()
        rest[self.lasting] = 0.0
        return rest

    def stand(self, A: Floats, newest: dict[str, Floats], shares: dict[str, Floats]) -> Floats:
        """Put in place of all columns what they were, had every sample been alike.

        ``newest``: columns of the kinds, A each sample's matrix.  ``shares`` (count, each): by
        which share of such a one the present columns began, by age; 1 where there are none.
        Returns the sizes (n) of what the present columns are besides such shares of the new ones.
        """
        off = np.zeros(len(A))
        for name, column in newest.items():
            kind = getattr(self, name)
            share = shares.get(name, np.ones((kind.count, kind.each)))
            for age in range(kind.count):
                begin = kind.first + (kind.slot - 1 - age) % kind.count * kind.each
                place = slice(begin, begin + kind.each)
                own = self.values[:, place]
                off += np.abs(own - share[age] * column).sum(axis=1)
                off += 4 * SINGLE**2 * np.abs(own).sum(axis=1)
                self.values[:, place], column = column, A @ column
        return off * UP

    def sums(self, rows: Floats, state: Floats) -> tuple[Floats, Floats]:
        """Sizes of rows (r, n) of the sum of all: of what disturbs alone, and of all.

        In single precision, with its rounding counted by the largest ``state`` (n).
        """
        self._single[:] = self.values
        seen = np.empty((len(rows), self.misled.end), dtype=np.float32)
        _product(rows.astype(np.float32), self._single, seen)
        np.abs(seen, out=seen)
        known, end = self.known.end, self.boxes.end
        first = seen[:, :known].sum(axis=1).astype(float)
        result = np.stack([first, first + seen[:, known:end].sum(axis=1)], axis=1)
        if self.misled.each:
            pairs = seen[:, end:].reshape(len(rows), -1, 2)
            result += np.hypot(pairs[..., 0], pairs[..., 1]).sum(axis=1, dtype=float)[:, None]
        many = seen.shape[1]
        size = np.abs(rows) @ (state + many * FAINT)
        result = result * (1 + 2 * many * SINGLE) + 2 * (len(state) + 8) * SINGLE * size[:, None]
        return result[:, 0] * UP, result[:, 1] * UP


def _product(a: Reals, b: Reals, out: Reals) -> None:
    """a b, in blocks too small for the threads of BLAS, which wait for each other at full load."""
    width = max(1, BLOCK // a.size)
    for first in range(0, b.shape[1], width):
        part = slice(first, first + width)
        np.matmul(a, b[:, part], out=out[:, part])
