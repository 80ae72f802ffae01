"""Values, slopes and remainders of a graph of variables and numbers, at many places."""

from __future__ import annotations

import casadi as ca
import numpy as np

from .intervals import TANH, Floats, Program, most, outwards

OUT = 1 + 1e-10
"""Factor that covers rounding in sums of up to 800,000 terms, all >= 0."""
PARTS = 8
"""Parts of the segment to a deviation."""
AT_ONCE = 4000
"""Places that are evaluated at once."""
STEEPER = (1.0, 1.1, 1.2, 1.3, 1.5)
"""Slopes of secants that are tried, over tanh's mean slope on an interval."""
SMALL = 1e-9
"""Smallest width of an interval with a mean slope."""
DUST = 1e-14
"""Bound of the rounding in a few operations on doubles, as a share."""


class Graph:
    """A function (variables, numbers), linear up to remainders; each tanh is enclosed by a secant.

    ``inner``: arguments of those tanh whose argument contains no tanh.  ``outer``: the function
    with variables in place of these tanh.
    """

    def __init__(self, function: ca.Function) -> None:
        by, numbers = (ca.SX.sym(name, function.numel_in(k)) for k, name in enumerate("bn"))
        given, output = ca.vertcat(by, numbers), ca.densify(function(by, numbers))
        self.shape = output.numel(), by.numel()
        self.values = Program(given, [output])
        rest, steep, inner = _parted(output)
        self.steep = steep.numel()
        if self.steep:
            self.inner = Graph(ca.Function("inner", [by, numbers], [inner]))
            self.outer = Graph(ca.Function("outer", [ca.vertcat(by, steep), numbers], [rest]))
            return
        slope = ca.jacobian(output, by)
        bent = ca.jacobian(ca.vec(slope.nz[:]), by)
        self._places = np.array(slope.sparsity().get_triplet(), dtype=int).reshape(2, -1)
        first, third = np.array(bent.sparsity().get_triplet(), dtype=int).reshape(2, -1)
        self.bends = (*self._places[:, first], third)
        self._slopes, self._bent = Program(given, [slope]), Program(given, [bent, slope, output])

    def linear(self, at: Floats, sizes: Floats, products: Floats) -> tuple[Floats, Floats]:
        """Slopes (K, steps, outputs, variables) at points within the ends ``at``, and bounds of the
        remainders.

        Deviations are up to ``sizes`` (K, variables), with ``products`` of two.
        """
        n = sizes.shape[1]
        if not self.steep:
            ends = self._slopes(at)
            slopes = np.zeros((*ends.shape[:-1], *self.shape))
            slopes[..., self._places[0], self._places[1]] = ends
            middle, hull = slopes.mean(axis=0), np.array([at[0].min(axis=1), at[1].max(axis=1)])
            off = each(most(slopes - middle), sizes[:, None])
            return middle, (off + self.second_order(hull, sizes, products)[:, None]) * OUT
        ways, left = self.inner.linear(at, sizes, products)
        begun, way = self.inner.values(at), each(np.abs(ways), sizes[:, None]) + left
        steep = TANH(begun)
        share, shift, off = _secants(begun, steep, way * OUT)
        at = np.concatenate([at[..., :n], steep, at[..., n:]], axis=-1)
        sizes = np.hstack([sizes, (share * way + np.abs(shift) + off).max(axis=1) * OUT])
        every = sizes[:, :, None] * sizes[:, None] * OUT
        every[:, :n, :n] = products
        slopes, beside = self.outer.linear(at, sizes, every)
        by = slopes[..., n:]
        beside += np.abs(each(by, shift)) + each(np.abs(by), off + share * left)
        return slopes[..., :n] + by * share[..., None, :] @ ways, beside * OUT

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


def _parted(output: ca.SX) -> tuple[ca.SX, ...]:
    """Replace each tanh whose argument contains no tanh: the result, the new variables, and the
    arguments.
    """
    done, steep, inner = dict[int, ca.SX](), ca.SX(0, 1), ca.SX(0, 1)

    def of(x: ca.SX) -> ca.SX:
        nonlocal steep, inner
        if (key := x.element_hash()) not in done:
            parts = [of(x.dep(k)) for k in range(x.n_dep())]
            if parts:
                x = (ca.SX.unary, ca.SX.binary)[len(parts) - 1](x.op(), *parts)
            if x.is_op(ca.OP_TANH) and not ca.depends_on(x, steep):
                inner, x = ca.vertcat(inner, *parts), ca.SX.sym("tanh")
                steep = ca.vertcat(steep, x)
            done[key] = x
        return done[key]

    rest = ca.vertcat(*map(of, ca.vertsplit(ca.cse(output))))
    return rest, steep, inner


def _secants(begun: Floats, steep: Floats, way: Floats) -> Floats:
    """Secants of tanh for deviations up to ``way`` from points within ``begun``.

    Returns slopes, offsets, and bounds of the errors.  ``steep``: tanh of ``begun``.  The
    difference between tanh and a line has its extremes at ends or where the slopes are equal.
    """
    low, high = outwards([begun[0] - way, begun[1] + way])
    best = np.full((3, *way.shape), np.inf)
    chord = (np.tanh(high) - np.tanh(low)) / np.maximum(high - low, SMALL)
    for steeper in STEEPER:
        share = np.minimum(steeper * chord, 1.0)
        turn = np.arctanh(np.minimum(np.sqrt(1 - share), 1 - DUST))
        places = np.array([low, high, np.clip(turn, low, high), np.clip(-turn, low, high)])
        ends, rest = TANH(np.array([places, places])) - share * places, steep - share * begun[::-1]
        least, top = ends[0].min(axis=0), ends[1].max(axis=0)
        off = (top - least + rest[1] - rest[0]) / 2 + DUST * (1 + np.abs(places).max(axis=0))
        best = np.where(off < best[2], [share, (top + least - rest.sum(axis=0)) / 2, off], best)
    return best


def each(matrices: Floats, vectors: Floats) -> Floats:
    """Products of matrices (..., m, n) with vectors (..., n)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
