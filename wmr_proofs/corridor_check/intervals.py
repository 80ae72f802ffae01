"""Graphs over intervals at many places at once, every result rounded outwards.

Results of sums, products, quotients and roots are those of IEEE doubles, moved outwards by one
unit; other functions are python-flint's.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
from flint import arb
from numpy.typing import ArrayLike, NDArray

from wmr_ctrl.world.model.graph import SELECT, read

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class RefusedError(ArithmeticError):
    """The certificate is refused; the message is the reason as a clause."""


def most(ends: Floats) -> Floats:
    """Largest absolute values of intervals."""
    return np.asarray(np.abs(ends).max(axis=0))


def outwards(ends: ArrayLike) -> Floats:
    """Ends of intervals, each moved outwards to the next double."""
    return np.asarray(np.nextafter(np.asarray(ends).T, [-np.inf, np.inf]).T)


def _flag(yes: Flags, no: Flags) -> Floats:
    if (yes == no).any():
        raise RefusedError("a condition is undecided on its box")
    return np.array([yes, yes], dtype=float)


def _true(a: Floats) -> tuple[Flags, Flags]:
    return (a[0] > 0) | (a[1] < 0), (a == 0).all(axis=0)


def _equal(a: Floats, b: Floats) -> tuple[Flags, Flags]:
    return (a == b[::-1]).all(axis=0), (a[1] < b[0]) | (a[0] > b[1])


def _product(a: Floats, b: Floats) -> Floats:
    ways = a[:, None] * b
    return outwards([ways.min(axis=(0, 1)), ways.max(axis=(0, 1))])


def _inverse(a: Floats) -> Floats:
    apart = (a[0] > 0) | (a[1] < 0)
    return outwards(np.where(apart, np.divide(1, a[::-1]), np.nan))


def _size(a: Floats) -> Floats:
    sizes = np.abs(a)
    least = np.where((a[0] <= 0) & (a[1] >= 0), 0.0, sizes.min(axis=0))
    return np.array([least, sizes.max(axis=0)])


def _by_flint(operation: Callable[[arb], arb]) -> Callable[[Floats], Floats]:
    def ends(low: float, high: float) -> tuple[float, float]:
        value = operation(arb(low).union(arb(high)))
        return float(value.lower()), float(value.upper())

    every = np.frompyfunc(ends, 2, 2)
    return lambda a: outwards(np.array(every(*a), dtype=float))


TANH = _by_flint(arb.tanh)


def _rising(operation: Callable[[arb], arb]) -> Callable[[Floats], Floats]:
    rule = _by_flint(operation)
    return lambda a: rule(np.array([a, a]))[[0, 1], [0, 1]]


RULES: dict[int, Callable[..., Floats]] = {
    SELECT: lambda c, a, b: np.asarray(np.where(_flag(*_true(c)) > 0, a, b)),
    ca.OP_LT: lambda a, b: _flag(a[1] < b[0], a[0] >= b[1]),
    ca.OP_LE: lambda a, b: _flag(a[1] <= b[0], a[0] > b[1]),
    ca.OP_EQ: lambda a, b: _flag(*_equal(a, b)),
    ca.OP_NE: lambda a, b: _flag(*reversed(_equal(a, b))),
    ca.OP_NOT: lambda a: _flag(*reversed(_true(a))),
    ca.OP_AND: lambda a, b: _flag(_true(a)[0] & _true(b)[0], _true(a)[1] | _true(b)[1]),
    ca.OP_OR: lambda a, b: _flag(_true(a)[0] | _true(b)[0], _true(a)[1] & _true(b)[1]),
    ca.OP_SIGN: lambda a: 2 * _flag(a[0] > 0, a[1] < 0) - 1,
    ca.OP_ADD: lambda a, b: outwards(a + b),
    ca.OP_SUB: lambda a, b: outwards(a - b[::-1]),
    ca.OP_MUL: _product,
    ca.OP_DIV: lambda a, b: _product(a, _inverse(b)),
    ca.OP_INV: _inverse,
    ca.OP_NEG: lambda a: -a[::-1],
    ca.OP_SQ: lambda a: outwards(_size(a) ** 2),
    ca.OP_TWICE: lambda a: 2 * a,
    ca.OP_SQRT: lambda a: outwards(np.sqrt(a)),
    ca.OP_EXP: _rising(arb.exp),
    ca.OP_EXPM1: _rising(arb.expm1),
    ca.OP_SIN: _by_flint(arb.sin),
    ca.OP_COS: _by_flint(arb.cos),
    ca.OP_TANH: _rising(arb.tanh),
    ca.OP_FABS: _size,
    ca.OP_FMIN: np.minimum,
    ca.OP_FMAX: np.maximum,
}


class Program:
    """Evaluator of the non-zero entries of some expressions of one column."""

    def __init__(self, by: ca.SX, outputs: list[ca.SX]) -> None:
        """Read the expressions as one graph, entry after entry."""
        every = ca.vertcat(*(ca.vec(item.nz[:]) for item in outputs))
        graph = read(ca.Function("checked", [by], [every]), ["i"], ("y",))
        stores = {item.index: item.node for item in graph.stores}
        self._nodes, self._stores = graph.nodes, [stores[k] for k in range(len(stores))]
        stay = set(self._stores)
        last = {k: n for n, node in enumerate(graph.nodes) for k in node.operands}
        self._done = [[k for k in {*node.operands} if last[k] == n and k not in stay]
                      for n, node in enumerate(graph.nodes)]  # fmt: skip

    def __call__(self, given: Floats) -> Floats:
        """Ends (2, ..., entries) for ends (2, ..., inputs); RefusedError outside of a domain."""
        values = dict[int, Floats]()
        with np.errstate(all="ignore"):
            for n, node in enumerate(self._nodes):
                if node.place is not None:
                    values[n] = given[..., node.place[1]]
                elif node.op == ca.OP_CONST:
                    values[n] = np.full(given.shape[:-1], node.number)
                elif node.op in RULES:
                    values[n] = RULES[node.op](*(values[k] for k in node.operands))
                else:
                    raise RefusedError(f"operation {node.op} of CasADi has no rule")
                for k in self._done[n]:
                    del values[k]
        ends = np.stack([values[k] for k in self._stores], axis=-1)
        if not np.isfinite(ends).all():
            raise RefusedError("an operation leaves its domain on its box")
        return ends
