"""Values, slopes and remainders of a graph of variables and numbers, at many places."""

from __future__ import annotations

import casadi as ca
import numpy as np

from .intervals import Floats, Program, most, outwards

OUT = 1 + 1e-10
"""Factor that covers rounding in sums of up to 800,000 terms, all >= 0."""
PARTS = 8
"""Parts of the segment to a deviation."""
AT_ONCE = 4000
"""Places that are evaluated at once."""


class Graph:
    """One graph, a function (variables, numbers)."""

    def __init__(self, function: ca.Function) -> None:
        by, numbers = (ca.SX.sym(name, function.numel_in(k)) for k, name in enumerate("bn"))
        output = ca.densify(function(by, numbers))
        self.shape = output.numel(), by.numel()
        slope = ca.jacobian(output, by)
        bent = ca.jacobian(ca.vec(slope.nz[:]), by)
        self._places = np.array(slope.sparsity().get_triplet(), dtype=int).reshape(2, -1)
        first, third = np.array(bent.sparsity().get_triplet(), dtype=int).reshape(2, -1)
        self.bends = (*self._places[:, first], third)
        given = ca.vertcat(by, numbers)
        self.values, self._slopes, self._bent = (
            Program(given, parts) for parts in ([output], [slope], [bent, slope, output])
        )

    def slopes(self, given: Floats) -> Floats:
        """Lower and upper ends (2, ..., outputs, variables) of the gradients."""
        ends = self._slopes(given)
        result = np.zeros((*ends.shape[:-1], *self.shape))
        result[..., self._places[0], self._places[1]] = ends
        return result

    def second_order(self, given: Floats, sizes: Floats, products: Floats) -> Floats:
        """Largest second-order terms (K, outputs) for points within the ends ``given``, by Taylor's
        integral.

        Deviations are up to ``sizes`` (K, variables), with ``products`` of two.
        """
        outputs, one, two = self.bends
        result = np.zeros((len(sizes), self.shape[0]))
        weights = np.array([2 * (PARTS - k) - 1 for k in range(PARTS)]) / (2 * PARTS**2)
        share = np.arange(1, PARTS + 1)[:, None] / PARTS * OUT
        for k in range(0, len(sizes), AT_ONCE // PARTS):
            at = slice(k, k + AT_ONCE // PARTS)
            ends = np.repeat(given[:, at, None], PARTS, axis=2)
            wide = share * sizes[at, None]
            low, high = ends[..., : sizes.shape[1]]
            beside = np.where(wide > 0, outwards([low - wide, high + wide]), [low, high])
            ends[..., : sizes.shape[1]] = beside
            bent = np.tensordot(weights, most(self._bent(ends))[..., : len(one)], (0, 1))
            np.add.at(result[at].T, outputs, (bent * products[at][:, one, two]).T)
        return result * OUT


def each(matrices: Floats, vectors: Floats) -> Floats:
    """Products of matrices (..., m, n) with vectors (..., n)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
