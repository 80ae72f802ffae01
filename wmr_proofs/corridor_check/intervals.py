"""Graphs over intervals at many places at once, every result rounded outwards.

Sums, products, quotients and roots are those of IEEE doubles, moved by one unit; other functions
are python-flint's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import casadi as ca
import numpy as np
from flint import arb
from numpy.typing import NDArray

from wmr_ctrl.world.model.graph import SELECT, read

Floats = NDArray[np.float64]
Interval: TypeAlias = "tuple[Floats, Floats]"
"""Lower and upper ends, place by place."""


class RefusedError(ArithmeticError):
    """The certificate is refused: the reason as a clause."""


def most(ends: Sequence[Floats]) -> Floats:
    """Largest absolute values of lower and upper ends."""
    return np.asarray(np.maximum(np.abs(ends[0]), np.abs(ends[1])))


def _out(low: Floats, high: Floats) -> Interval:
    return np.nextafter(low, -np.inf), np.nextafter(high, np.inf)


def _flag(yes: NDArray[np.bool_], no: NDArray[np.bool_]) -> Interval:
    if (yes == no).any():
        raise RefusedError("a condition is undecided on its box")
    return yes.astype(float), yes.astype(float)


def _true(a: Interval) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    return (a[0] > 0) | (a[1] < 0), (a[0] == 0) & (a[1] == 0)


def _equal(a: Interval, b: Interval) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    return (a[0] == b[1]) & (a[1] == b[0]), (a[1] < b[0]) | (a[0] > b[1])


def _select(c: Interval, a: Interval, b: Interval) -> Interval:
    yes = _flag(*_true(c))[0] > 0
    return np.where(yes, a[0], b[0]), np.where(yes, a[1], b[1])


def _negative(a: Interval) -> Interval:
    return -a[1], -a[0]


def _product(a: Interval, b: Interval) -> Interval:
    ways = [one * other for one in a for other in b]
    return _out(np.minimum.reduce(ways), np.maximum.reduce(ways))


def _inverse(a: Interval) -> Interval:
    apart = (a[0] > 0) | (a[1] < 0)
    return _out(np.where(apart, 1 / a[1], -np.inf), np.where(apart, 1 / a[0], np.inf))


def _size(a: Interval) -> Interval:
    low = np.where((a[0] <= 0) & (a[1] >= 0), 0.0, np.minimum(abs(a[0]), abs(a[1])))
    return low, np.maximum(abs(a[0]), abs(a[1]))


def _square(a: Interval) -> Interval:
    low, high = _size(a)
    return _out(low * low, high * high)


def _by_flint(operation: Callable[[arb], arb]) -> Callable[[Interval], Interval]:
    def ends(low: float, high: float) -> tuple[float, float]:
        value = operation(arb(low).union(arb(high)))
        return float(value.lower()), float(value.upper())

    every = np.frompyfunc(ends, 2, 2)
    return lambda a: _out(*(end.astype(float) for end in every(*a)))


def _rising(operation: Callable[[arb], arb]) -> Callable[[Interval], Interval]:
    rule = _by_flint(operation)
    return lambda a: (rule((a[0], a[0]))[0], rule((a[1], a[1]))[1])


RULES: dict[int, Callable[..., Interval]] = {
    SELECT: _select,
    ca.OP_LT: lambda a, b: _flag(a[1] < b[0], a[0] >= b[1]),
    ca.OP_LE: lambda a, b: _flag(a[1] <= b[0], a[0] > b[1]),
    ca.OP_EQ: lambda a, b: _flag(*_equal(a, b)),
    ca.OP_NE: lambda a, b: _flag(*reversed(_equal(a, b))),
    ca.OP_NOT: lambda a: _flag(*reversed(_true(a))),
    ca.OP_AND: lambda a, b: _flag(_true(a)[0] & _true(b)[0], _true(a)[1] | _true(b)[1]),
    ca.OP_OR: lambda a, b: _flag(_true(a)[0] | _true(b)[0], _true(a)[1] & _true(b)[1]),
    ca.OP_SIGN: lambda a: (2 * (up := _flag(a[0] > 0, a[1] < 0)[0]) - 1, 2 * up - 1),
    ca.OP_ADD: lambda a, b: _out(a[0] + b[0], a[1] + b[1]),
    ca.OP_SUB: lambda a, b: _out(a[0] - b[1], a[1] - b[0]),
    ca.OP_MUL: _product,
    ca.OP_DIV: lambda a, b: _product(a, _inverse(b)),
    ca.OP_INV: _inverse,
    ca.OP_NEG: _negative,
    ca.OP_SQ: _square,
    ca.OP_TWICE: lambda a: (2 * a[0], 2 * a[1]),
    ca.OP_SQRT: lambda a: _out(np.sqrt(a[0]), np.sqrt(a[1])),
    ca.OP_EXP: _rising(arb.exp),
    ca.OP_EXPM1: _rising(arb.expm1),
    ca.OP_SIN: _by_flint(arb.sin),
    ca.OP_COS: _by_flint(arb.cos),
    ca.OP_TANH: _rising(arb.tanh),
    ca.OP_FABS: _size,
    ca.OP_FMIN: lambda a, b: (np.minimum(a[0], b[0]), np.minimum(a[1], b[1])),
    ca.OP_FMAX: lambda a, b: (np.maximum(a[0], b[0]), np.maximum(a[1], b[1])),
}


class Program:
    """Non-zero entries of some expressions of one column."""

    def __init__(self, by: ca.SX, outputs: list[ca.SX]) -> None:
        """Read them, one after the other."""
        every = ca.vertcat(*(ca.vec(item.nz[:]) for item in outputs))
        graph = read(ca.Function("checked", [by], [every]), ["i"], ("y",))
        stores = {item.index: item.node for item in graph.stores}
        self._nodes, self._stores = graph.nodes, [stores[k] for k in range(len(stores))]
        stay = set(self._stores)
        last = {k: n for n, node in enumerate(graph.nodes) for k in node.operands}
        self._done = [[k for k in {*node.operands} if last[k] == n and k not in stay]
                      for n, node in enumerate(graph.nodes)]  # fmt: skip

    def __call__(self, low: Floats, high: Floats) -> Interval:
        """Ends (..., entries) for ends (..., inputs); RefusedError outside of a domain."""
        values = dict[int, Interval]()
        blank = np.zeros(low.shape[:-1])
        with np.errstate(all="ignore"):
            for n, node in enumerate(self._nodes):
                if node.place is not None:
                    place = node.place[1]
                    values[n] = low[..., place], high[..., place]
                elif node.op == ca.OP_CONST:
                    values[n] = blank + node.number, blank + node.number
                elif node.op in RULES:
                    values[n] = RULES[node.op](*(values[k] for k in node.operands))
                else:
                    raise RefusedError(f"operation {node.op} of CasADi has no rule")
                for k in self._done[n]:
                    del values[k]
        ends = [np.stack([values[k][i] for k in self._stores], axis=-1) for i in (0, 1)]
        if not (np.isfinite(ends[0]).all() and np.isfinite(ends[1]).all()):
            raise RefusedError("an operation leaves its domain on its box")
        return ends[0], ends[1]
