"""Generators of a flowpipe: disturbances of recent samples, propagated by the loop."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.theory.checks.loop import IntArray

from .loop import UP
from .midradius import ROUNDED

SINGLE = 2.0**-24
"""Relative error of a single-precision result."""
FAINT = 1e-30
"""Size that such a result may take for 0."""
BLOCK = 2**17
"""Products of numbers below which OpenBLAS takes one thread, and the results stay in a cache."""


@dataclass(frozen=True)
class CarriedColumns:
    """Generators ``weight`` (m, K) times ``values`` (n, m, K) of K samples, the oldest first.

    ``born`` (K): the sample that each belongs to.  Of a sample's m generators, those before the
    first of ``ends`` are disturbances, those until the second are the law's force and box
    components, and the rest is a disc's pair.
    """

    born: IntArray
    values: Floats
    weight: Floats
    ends: tuple[int, int]

    @property
    def bent(self) -> Floats:
        """Weights (K, ...) of the law's force and of the boxes' components."""
        return self.weight[slice(*self.ends)].T

    @property
    def sizes(self) -> Floats:
        """Largest size of each number of the state (n), with rounding."""
        return sizes_of(self.values, self.weight) * UP

    def later(self, P: Floats, oldest: int) -> tuple[CarriedColumns, Floats]:
        """Generators times P, without those born before ``oldest``; and the sizes (n) of the
        latter.
        """
        lost = int(np.searchsorted(self.born, oldest))
        values = (P @ self.values.reshape(len(P), -1)).reshape(self.values.shape)
        gone = sizes_of(values[..., :lost], self.weight[:, :lost])
        born, weight = self.born[lost:], self.weight[:, lost:]
        return replace(self, born=born, values=values[..., lost:], weight=weight), gone

    def and_more(self, *new: CarriedColumns) -> CarriedColumns:
        """These columns, followed by younger ones."""
        every = (self, *new)
        born, values, weight = (
            np.concatenate([getattr(item, name) for item in every], axis=-1)
            for name in ("born", "values", "weight")
        )
        return CarriedColumns(born, values, weight, self.ends)

    def _from(self, first: int, last: int | None) -> CarriedColumns:
        part = slice(first, last)
        values, weight = self.values[..., part], self.weight[:, part]
        return CarriedColumns(self.born[part], values, weight, self.ends)

    def thinned(self, first: int, last: int, apart: int) -> tuple[CarriedColumns, Floats]:
        """Order reduction: keep one in ``apart`` of the samples born from ``first`` to ``last``.

        The first and the last are kept.  Each sample in between is replaced by an interpolation of
        kept ones; the remainder is returned as a box with sizes (n).
        """
        begin, end = np.searchsorted(self.born, (first, last + 1)).tolist()
        count = end - begin
        if count < 3 or apart < 2:
            return self, np.zeros(len(self.values))
        old = self._from(begin, end)
        nodes, share = _shares(tuple((old.born - old.born[0]).tolist()), apart)
        born, ends = old.born, old.values[..., nodes]
        between, size = ends @ share, np.abs(ends) @ share
        off = np.abs(old.values - between) + 4 * ROUNDED * (np.abs(old.values) + size)
        new = CarriedColumns(born[nodes], ends, (old.weight @ share.T) * UP, self.ends)
        result = self._from(0, begin).and_more(new, self._from(end, None))
        return result, sizes_of(off, old.weight)

    def older(self, samples: int) -> CarriedColumns:
        """These columns, with ``born`` shifted by ``samples``."""
        return replace(self, born=self.born + samples)

    def sums(self, rows: Floats, sizes: Floats) -> tuple[Floats, Floats]:
        """Sizes of the sum in each of the rows (..., r, n): for disturbances alone, and for all
        generators.

        Computed in single precision, with its rounding bounded by ``sizes``.
        """
        count = len(self.born)
        flat = (self.values * self.weight).reshape(len(self.values), -1)
        parts = np.split(flat, [end * count for end in self.ends], axis=1)
        known, bent = (_absolute(rows, part) for part in parts[:2])
        if parts[2].size:
            pairs = rows @ parts[2]
            known += np.hypot(pairs[..., :count], pairs[..., count:]).sum(axis=-1)
        many = self.weight.size
        off = 2 * (rows.shape[-1] + 8) * SINGLE * (np.abs(rows) @ (sizes + many * FAINT))
        share = (1 + 2 * many * SINGLE) * UP
        return known * share + off * UP, (known + bent) * share + off * UP


@lru_cache(maxsize=64)
def _shares(born: tuple[int, ...], apart: int) -> tuple[IntArray, Floats]:
    """Indices of kept samples, including both ends, and weights (kept, samples) for
    interpolation.
    """
    last = len(born) - 1
    nodes = np.unique(np.linspace(0, last, -(-last // apart) + 1).round().astype(int))
    ends = np.array(born)[nodes]
    return nodes, np.array([np.interp(born, ends, unit) for unit in np.eye(len(nodes))])


def sizes_of(values: Floats, weight: Floats) -> Floats:
    """Largest size of each number of the state (n)."""
    return np.asarray(np.abs(values).reshape(len(values), -1) @ weight.ravel())


def _absolute(rows: Floats, columns: Floats) -> Floats:
    """Sums of absolute products, row by row, in blocks that are too small for BLAS threads."""
    result, single = np.zeros(rows.shape[:-1]), rows.astype(np.float32)
    width = max(1, BLOCK // (rows.shape[-1] * rows.shape[-2]))
    for first in range(0, columns.shape[1], width):
        seen = single @ columns[:, first : first + width].astype(np.float32)
        np.abs(seen, out=seen)
        result += np.einsum("...k->...", seen)
    return result
