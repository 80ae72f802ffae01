"""Graphs in spans: evaluated at thousands of places of a path, one array operation per node."""

from collections.abc import Callable

import casadi as ca
import numpy as np
from flint import arb
from numpy.typing import NDArray

from wmr_ctrl.theory.checks.error_coordinates import Floats
from wmr_ctrl.world.model.graph import SELECT, read

from . import elementary
from .enclosure import OpenBoxError
from .midradius import OUTWARD, ROUNDED, MidRadius


class MidRadiusGraph:
    """A CasADi expression of columns, at many places at once."""

    def __init__(self, name: str, inputs: list[ca.SX], output: ca.SX) -> None:
        """Read the graph; ``pattern`` (row, column) are its non-zero entries."""
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
                yes = self._decided(*_truth(given[0]))
                return MidRadius(*(np.where(yes, getattr(given[1], key), getattr(given[2], key))
                              for key in ("middle", "radius")))  # fmt: skip
            if op in _CONDITIONS:
                return MidRadius(self._decided(*_CONDITIONS[op](*given)).astype(float))
            if op == ca.OP_SIGN:
                zero = MidRadius(0.0)
                up = self._decided(_below(zero, given[0])[0], _below(given[0], zero)[0])
                return MidRadius(np.where(up, 1.0, -1.0))
            if op not in _OPERATIONS:
                raise OpenBoxError(f"operation {op} of CasADi is not covered")
            return _OPERATIONS[op](*given)
        except OpenBoxError as error:
            raise OpenBoxError(f"{self.name}: {error}") from error

    def _decided(self, yes: NDArray[np.bool_], no: NDArray[np.bool_]) -> NDArray[np.bool_]:
        if (yes == no).any():
            raise OpenBoxError("a condition cannot be decided")
        return yes


def _series_or_balls(
    series: Callable[[MidRadius], MidRadius], most: float, ball: Callable[[arb], arb]
) -> Callable[[MidRadius], MidRadius]:
    """Use a series up to its largest argument, and balls beyond it, element by element."""
    return lambda a: series(a) if (a.most <= most).all() else a.by_balls(ball)


_Both = tuple[NDArray[np.bool_], NDArray[np.bool_]]


def _apart(a: MidRadius, b: MidRadius) -> tuple[Floats, Floats]:
    """Difference b - a of midpoints, and the size from which it decides."""
    gap = b.middle - a.middle
    return gap, (a.radius + b.radius) * OUTWARD + ROUNDED * np.abs(gap) * (a.radius + b.radius > 0)


def _truth(a: MidRadius) -> _Both:
    """Masks of numbers that are certainly not 0, which count as true, and that are 0."""
    return np.abs(a.middle) > a.radius, (a.middle == 0) & (a.radius == 0)


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
    ca.OP_NOT: lambda a: _truth(a)[::-1],
    ca.OP_AND: lambda a, b: (_truth(a)[0] & _truth(b)[0], _truth(a)[1] | _truth(b)[1]),
    ca.OP_OR: lambda a, b: (_truth(a)[0] | _truth(b)[0], _truth(a)[1] & _truth(b)[1]),
}
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
    ca.OP_EXP: _series_or_balls(elementary.exponential, elementary.EXPONENT, arb.exp),
    ca.OP_EXPM1: lambda a: a.by_balls(arb.expm1),
    ca.OP_SIN: _series_or_balls(elementary.sine, elementary.ANGLE, arb.sin),
    ca.OP_COS: _series_or_balls(elementary.cosine, elementary.ANGLE, arb.cos),
    ca.OP_TANH: elementary.hyperbolic_tangent,
    ca.OP_FMIN: lambda a, b: _lesser(a, b),
    ca.OP_FMAX: lambda a, b: -_lesser(-a, -b),
}


def _lesser(a: MidRadius, b: MidRadius) -> MidRadius:
    """The minimum: the lesser midpoint, with the larger of both radii."""
    return MidRadius(np.minimum(a.middle, b.middle), np.maximum(a.radius, b.radius))
