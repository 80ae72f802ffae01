"""Spans: many intervals at once, each a midpoint and a radius in doubles, rounded outwards.

A graph that is evaluated at thousands of places of a path takes an operation of arrays for each
node.  What is not a sum, product or quotient is taken in balls, element by element.
"""

from __future__ import annotations

from collections.abc import Callable
from types import EllipsisType
from typing import TypeAlias

import casadi as ca
import numpy as np
from flint import arb
from numpy.typing import NDArray

from wmr_ctrl.checks.world import Floats
from wmr_ctrl.corridor.enclosure import OpenBoxError
from wmr_ctrl.model.graph import SELECT, read

ROUNDED, OUTWARD, SMALLEST = 2.0**-52, 1 + 2.0**-48, 1e-300
"""Twice what a result is off by, what widens a radius for its own rounding, and what is added."""


Places: TypeAlias = "tuple[slice | int | EllipsisType | None, ...]"


class MidRadius:
    """Numbers within ``radius`` of ``middle``, element by element."""

    __slots__ = ("middle", "radius")

    def __init__(self, middle: Floats | float, radius: Floats | float = 0.0) -> None:
        self.middle, self.radius = np.asarray(middle), np.asarray(radius)

    @property
    def most(self) -> Floats:
        """Doubles that are at least the sizes of all numbers within."""
        return np.asarray((np.abs(self.middle) + self.radius) * OUTWARD + SMALLEST)

    def __add__(self, other: MidRadius) -> MidRadius:
        middle = self.middle + other.middle
        return _rounded(middle, self.radius + other.radius)

    def __neg__(self) -> MidRadius:
        return MidRadius(-self.middle, self.radius)

    def __sub__(self, other: MidRadius) -> MidRadius:
        return self + -other

    def __mul__(self, other: MidRadius) -> MidRadius:
        wide = np.abs(self.middle) * other.radius + self.radius * other.most
        return _rounded(self.middle * other.middle, wide)

    def __truediv__(self, other: MidRadius) -> MidRadius:
        size = np.abs(other.middle)
        least = (size - other.radius) / OUTWARD
        if not (least > 0).all():
            raise OpenBoxError("a quotient by what may be 0")
        middle = self.middle / other.middle
        return _rounded(middle, (self.radius + np.abs(middle) * other.radius) / least)

    def __matmul__(self, other: MidRadius) -> MidRadius:
        """Products of stacked matrices, of fewer than 100 columns."""
        sizes = np.abs(self.middle)
        wide = sizes @ (other.radius + 100 * ROUNDED * np.abs(other.middle))
        wide = wide + self.radius @ other.most
        return MidRadius(self.middle @ other.middle, wide * OUTWARD + SMALLEST)

    def __getitem__(self, places: Places) -> MidRadius:
        radius = np.broadcast_to(self.radius, self.middle.shape)
        return MidRadius(self.middle[places], radius[places])

    def __abs__(self) -> MidRadius:
        return MidRadius(np.abs(self.middle), self.radius)

    def by_balls(self, operation: Callable[[arb], arb]) -> MidRadius:
        """An operation on balls, element by element."""
        middle, radius = np.broadcast_arrays(self.middle, self.radius)
        pairs = zip(middle.ravel().tolist(), radius.ravel().tolist(), strict=True)
        result = [operation(arb(*pair)) for pair in pairs]
        if not all(item.is_finite() for item in result):
            raise OpenBoxError("an operation leaves its domain")
        new, wide = ([float(part(x)) for x in result] for part in (arb.mid, arb.rad))
        shape = middle.shape
        return _rounded(np.array(new).reshape(shape), np.array(wide).reshape(shape))


def _rounded(middle: Floats, radius: Floats) -> MidRadius:
    return MidRadius(middle, (radius + ROUNDED * np.abs(middle)) * OUTWARD + SMALLEST)


class MidRadiusGraph:
    """A CasADi expression of columns, at many places at once."""

    def __init__(self, name: str, inputs: list[ca.SX], output: ca.SX) -> None:
        """Read the graph; ``pattern`` (row, column) are its entries that can differ from 0."""
        self.name, self.pattern = name, np.array(output.sparsity().get_triplet()).reshape(2, -1)
        places = [f"i{k}" for k in range(len(inputs))]
        self._place = {place: k for k, place in enumerate(places)}
        graph = read(ca.Function("spans", inputs, [output.nz[:]]), places, ("y",))
        self._nodes = graph.nodes
        stores = {store.index: store.node for store in graph.stores}
        self._stores = [stores[k] for k in range(self.pattern.shape[1])]
        last = {k: n for n, node in enumerate(self._nodes) for k in node.operands}
        stay = set(self._stores)
        self._gone: list[list[int]] = [[] for _ in self._nodes]
        for k, n in last.items():
            if k not in stay:
                self._gone[n].append(k)

    def __call__(self, *values: list[MidRadius]) -> MidRadius:
        """Entries in the order of ``pattern``, the last axis; OpenBoxError where undecided."""
        done: dict[int, MidRadius] = {}
        for n, node in enumerate(self._nodes):
            if node.place is not None:
                done[n] = values[self._place[node.place[0]]][node.place[1]]
            elif node.op == ca.OP_CONST:
                done[n] = MidRadius(node.number)
            else:
                done[n] = self._value(node.op, [done[k] for k in node.operands])
            for k in self._gone[n]:
                del done[k]
        result = [done[k] for k in self._stores]
        shape = np.broadcast_shapes(*(np.shape(x.middle) for part in values for x in part))
        middle, radius = (
            np.stack([np.broadcast_to(getattr(x, key), shape) for x in result], axis=-1)
            for key in ("middle", "radius")
        )
        return MidRadius(middle, radius)

    def _value(self, op: int, given: list[MidRadius]) -> MidRadius:
        try:
            if op == SELECT:
                yes = self._decided(given[0].middle != 0, given[0].middle == 0)
                return MidRadius(*(np.where(yes, getattr(given[1], key), getattr(given[2], key))
                              for key in ("middle", "radius")))  # fmt: skip
            if op in _CONDITIONS:
                return MidRadius(self._decided(*_CONDITIONS[op](*given)).astype(float))
            if op not in _OPERATIONS:
                raise OpenBoxError(f"operation {op} of CasADi is not covered")
            return _OPERATIONS[op](*given)
        except OpenBoxError as error:
            raise OpenBoxError(f"{self.name}: {error}") from error

    def _decided(self, yes: NDArray[np.bool_], no: NDArray[np.bool_]) -> NDArray[np.bool_]:
        if (yes == no).any():
            raise OpenBoxError("a condition cannot be decided")
        return yes


_Both = tuple[NDArray[np.bool_], NDArray[np.bool_]]


def _apart(a: MidRadius, b: MidRadius) -> tuple[Floats, Floats]:
    """Midpoints' difference b - a, and the size at which it decides."""
    gap = b.middle - a.middle
    return gap, (a.radius + b.radius) * OUTWARD + ROUNDED * np.abs(gap) * (a.radius + b.radius > 0)


def _below(a: MidRadius, b: MidRadius) -> _Both:
    gap, wide = _apart(a, b)
    return gap > wide, gap <= -wide


def _below_or_equal(a: MidRadius, b: MidRadius) -> _Both:
    gap, wide = _apart(a, b)
    return gap >= wide, gap < -wide


def _equal(a: MidRadius, b: MidRadius) -> _Both:
    exact = (a.radius == 0) & (b.radius == 0)
    differs = np.abs(a.middle - b.middle) > (a.radius + b.radius) * OUTWARD
    return exact & (a.middle == b.middle), differs


_CONDITIONS: dict[int, Callable[..., _Both]] = {
    ca.OP_LT: _below,
    ca.OP_LE: _below_or_equal,
    ca.OP_EQ: _equal,
    ca.OP_NE: lambda a, b: _equal(a, b)[::-1],
    ca.OP_NOT: lambda a: (a.middle == 0, a.middle != 0),
    ca.OP_AND: lambda a, b: (
        (a.middle != 0) & (b.middle != 0), (a.middle == 0) | (b.middle == 0)
    ),
    ca.OP_OR: lambda a, b: ((a.middle != 0) | (b.middle != 0), (a.middle == 0) & (b.middle == 0)),
}  # fmt: skip
"""Where a condition certainly holds, and where it certainly does not."""
_OPERATIONS: dict[int, Callable[..., MidRadius]] = {
    ca.OP_ADD: lambda a, b: a + b,
    ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b,
    ca.OP_DIV: lambda a, b: a / b,
    ca.OP_INV: lambda a: MidRadius(1.0) / a,
    ca.OP_NEG: lambda a: -a,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_TWICE: lambda a: MidRadius(2 * a.middle, 2 * a.radius),
    ca.OP_FABS: abs,
    ca.OP_SQRT: lambda a: a.by_balls(arb.sqrt),
    ca.OP_EXP: lambda a: a.by_balls(arb.exp),
    ca.OP_EXPM1: lambda a: a.by_balls(arb.expm1),
    ca.OP_SIN: lambda a: a.by_balls(arb.sin),
    ca.OP_COS: lambda a: a.by_balls(arb.cos),
    ca.OP_TANH: lambda a: a.by_balls(arb.tanh),
    ca.OP_FMIN: lambda a, b: _lesser(a, b),
    ca.OP_FMAX: lambda a, b: -_lesser(-a, -b),
}


def _lesser(a: MidRadius, b: MidRadius) -> MidRadius:
    """The minimum: within the larger of both radii of the lesser midpoint."""
    return MidRadius(np.minimum(a.middle, b.middle), np.maximum(a.radius, b.radius))
