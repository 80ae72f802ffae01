"""Columns of what disturbed each of the last samples, carried along by the loop's matrices."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wmr_ctrl.checks.loop import IntArray
from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.loop import UP
from wmr_ctrl.corridor.midradius import ROUNDED

SINGLE, FAINT = 2.0**-24, 1e-30
"""Share by which a single-precision result errs, and a size that it may take for 0."""
BLOCK = 2**17
"""Products of numbers below which OpenBLAS takes one thread, and the results stay in a cache."""


@dataclass(frozen=True)
class Kind:
    """Columns ``weight`` (K, m) times ``values`` (n, K, m) of K samples."""

    values: Floats
    weight: Floats

    @property
    def flat(self) -> Floats:
        """As one matrix (n, K m)."""
        return (self.values * self.weight).reshape(len(self.values), -1)

    def from_sample(self, first: int) -> Kind:
        """Without those of the first samples."""
        return Kind(self.values[:, first:], self.weight[first:])

    def sizes(self, last: int | None = None) -> Floats:
        """Of each number of the state (n), by all or by the first samples."""
        return np.einsum("nkm,km->n", np.abs(self.values[:, :last]), self.weight[:last])

    def and_more(self, new: Kind) -> Kind:
        """With those of later samples."""
        both = zip((self.values, self.weight), (new.values, new.weight), (1, 0), strict=True)
        return Kind(*(np.concatenate([old, more], axis=axis) for old, more, axis in both))

    def thinned(self, first: int, last: int, nodes: IntArray, share: Floats) -> tuple[Kind, Floats]:
        """Of some samples only some ``nodes``, and sizes (n) of what is beside these.

        Each of the samples is a share (samples, nodes) of these, with one sign, and a rest.
        """
        values, weight = self.values[:, first:last], self.weight[first:last]
        ends = values[:, nodes]
        between, size = (np.einsum("jk,nkm->njm", share, part) for part in (ends, np.abs(ends)))
        off = np.abs(values - between) + 4 * ROUNDED * (np.abs(values) + size)
        middle = Kind(ends, (share.T @ weight) * UP)
        before = Kind(self.values[:, :first], self.weight[:first])
        result = before.and_more(middle).and_more(self.from_sample(last))
        return result, np.einsum("njm,jm->n", off, weight)


@dataclass(frozen=True)
class CarriedColumns:
    """All columns, the oldest first; ``born`` (K): the first sample that each is part of.

    ``known``: of what disturbs, ``bent``: of the law's force, and of boxes' components; ``misled``:
    pairs of a disc.
    """

    born: IntArray
    known: Kind
    bent: Kind
    misled: Kind

    @property
    def kinds(self) -> tuple[Kind, Kind, Kind]:
        """All of them."""
        return self.known, self.bent, self.misled

    @property
    def sizes(self) -> Floats:
        """Of each number of the state (n), with rounding."""
        return np.asarray(sum(kind.sizes() for kind in self.kinds) * UP)

    def later(self, P: Floats, oldest: int) -> tuple[CarriedColumns, Floats]:
        """Multiplied by P, without those born before; sizes (n) of these."""
        lost, gone, kinds = int(np.searchsorted(self.born, oldest)), np.zeros(len(P)), []
        for kind in self.kinds:
            values = (P @ kind.values.reshape(len(P), -1)).reshape(kind.values.shape)
            moved = Kind(values, kind.weight)
            gone += moved.sizes(lost)
            kinds.append(moved.from_sample(lost))
        return CarriedColumns(self.born[lost:], *kinds), gone

    def and_more(self, new: CarriedColumns) -> CarriedColumns:
        """With younger ones."""
        pairs = zip(self.kinds, new.kinds, strict=True)
        kinds = (kind.and_more(more) for kind, more in pairs)
        return CarriedColumns(np.concatenate([self.born, new.born]), *kinds)

    def thinned(self, first: int, last: int, apart: int) -> tuple[CarriedColumns, Floats]:
        """Of those born from ``first`` until ``last`` one in so many, with the ends.

        Also sizes (n) of what is beside these, as a box.
        """
        begin, end = np.searchsorted(self.born, (first, last + 1)).tolist()
        count = end - begin
        if count < 3 or apart < 2:
            return self, np.zeros(len(self.known.values))
        nodes = np.array(sorted({*range(0, count, apart), count - 1}))
        born = self.born[begin:end]
        units = np.eye(len(nodes))
        share = np.array([np.interp(born, born[nodes], unit) for unit in units]).T
        both = [kind.thinned(begin, end, nodes, share) for kind in self.kinds]
        births = np.concatenate([self.born[:begin], born[nodes], self.born[end:]])
        off = np.asarray(sum(rest for _, rest in both))
        return CarriedColumns(births, *(kind for kind, _ in both)), off

    def with_more(self, share: float, more: float, other: CarriedColumns | None) -> CarriedColumns:
        """With larger weights of all that is not known, and at least those of others, if alike."""
        weight = self.bent.weight * share + more
        if other is not None and np.array_equal(other.born, self.born):
            weight = np.maximum(weight, other.bent.weight)
        return replace(self, bent=Kind(self.bent.values, weight))

    def older(self, samples: int) -> CarriedColumns:
        """The same, born so much later."""
        return replace(self, born=self.born + samples)

    def sums(self, rows: Floats, sizes: Floats) -> tuple[Floats, Floats]:
        """Sizes of rows (..., r, n) of the sum of all: of what disturbs alone, and of all.

        In single precision, with its rounding counted by the ``sizes``.
        """
        known, bent = (_absolute(rows, kind.flat) for kind in (self.known, self.bent))
        if self.misled.weight.size:
            pairs = rows @ self.misled.flat
            known += np.hypot(pairs[..., ::2], pairs[..., 1::2]).sum(axis=-1)
        many = sum(kind.weight.size for kind in self.kinds)
        off = 2 * (rows.shape[-1] + 8) * SINGLE * (np.abs(rows) @ (sizes + many * FAINT))
        share = (1 + 2 * many * SINGLE) * UP
        return known * share + off * UP, (known + bent) * share + off * UP


def _absolute(rows: Floats, columns: Floats) -> Floats:
    """Sums of the sizes of the products, by rows, in blocks too small for the threads of BLAS."""
    result, single = np.zeros(rows.shape[:-1]), rows.astype(np.float32)
    width = max(1, BLOCK // (rows.shape[-1] * rows.shape[-2]))
    for first in range(0, columns.shape[1], width):
        seen = single @ columns[:, first : first + width].astype(np.float32)
        np.abs(seen, out=seen)
        result += np.einsum("...k->...", seen)
    return result
