"""Graphs in balls: python-flint's midpoint and radius arithmetic, rounded outwards.

What is walked is the graph that C is made from (`wmr_ctrl.model.graph`).  A condition that a ball
leaves open is not guessed: `OpenBoxError` names the graph.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi as ca
from flint import arb

from wmr_ctrl.model.graph import SELECT, read

Balls = list[arb]


class OpenBoxError(ArithmeticError):
    """Values of a ball go two ways at a condition, or leave an operation's domain."""


class Enclosure:
    """A CasADi expression of named columns, evaluated in balls."""

    def __init__(self, name: str, inputs: Sequence[ca.SX], output: ca.SX) -> None:
        """Read the graph; only the entries of ``output`` that can differ from 0 are evaluated."""
        places = [f"i{k}" for k in range(len(inputs))]
        self.name = name
        self.pattern = list(zip(*output.sparsity().get_triplet(), strict=True))
        function = ca.Function("enclosed", list(inputs), [output.nz[:]])
        graph = read(function, places, ("y",))
        self._nodes = graph.nodes
        stores = {store.index: store.node for store in graph.stores}
        self._stores = [stores[k] for k in range(len(self.pattern))]
        self._place = {place: k for k, place in enumerate(places)}

    def __call__(self, *values: Balls) -> Balls:
        """The output's entries in the order of ``pattern`` (row, column)."""
        done: list[arb] = []
        for node in self._nodes:
            if node.place is not None:
                done.append(values[self._place[node.place[0]]][node.place[1]])
            elif node.op == ca.OP_CONST:
                done.append(arb(node.number))
            else:
                done.append(self._value(node.op, [done[k] for k in node.operands]))
        results = [done[k] for k in self._stores]
        if not all(value.is_finite() for value in results):
            raise OpenBoxError(f"{self.name}: an operation leaves its domain")
        return results

    def _value(self, op: int, given: Balls) -> arb:
        if op == SELECT:
            return given[1] if self._decided(op, given[0] != 0, given[0] == 0) else given[2]
        if op in _CONDITIONS:
            return arb(int(self._decided(op, *_CONDITIONS[op](*given))))
        if op == ca.OP_SIGN:
            return arb(1 if self._decided(op, given[0] > 0, given[0] < 0) else -1)
        if op not in _OPERATIONS:
            raise OpenBoxError(f"{self.name}: operation {op} of CasADi is not covered")
        return _OPERATIONS[op](*given)

    def _decided(self, op: int, yes: bool, no: bool) -> bool:
        if yes == no:
            raise OpenBoxError(f"{self.name}: a condition (operation {op}) cannot be decided")
        return yes


_Both = tuple[bool, bool]
_CONDITIONS: dict[int, Callable[..., _Both]] = {
    ca.OP_LT: lambda a, b: (a < b, a >= b),
    ca.OP_LE: lambda a, b: (a <= b, a > b),
    ca.OP_EQ: lambda a, b: (a == b, a != b),
    ca.OP_NE: lambda a, b: (a != b, a == b),
    ca.OP_NOT: lambda a: (a == 0, a != 0),
    ca.OP_AND: lambda a, b: (a != 0 and b != 0, a == 0 or b == 0),
    ca.OP_OR: lambda a, b: (a != 0 or b != 0, a == 0 and b == 0),
}
"""Whether a condition certainly holds, and whether it certainly does not."""
_OPERATIONS: dict[int, Callable[..., arb]] = {
    ca.OP_ADD: lambda a, b: a + b,
    ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b,
    ca.OP_DIV: lambda a, b: a / b,
    ca.OP_INV: lambda a: 1 / a,
    ca.OP_NEG: lambda a: -a,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_TWICE: lambda a: 2 * a,
    ca.OP_SQRT: arb.sqrt,
    ca.OP_EXP: arb.exp,
    ca.OP_EXPM1: arb.expm1,
    ca.OP_SIN: arb.sin,
    ca.OP_COS: arb.cos,
    ca.OP_TANH: arb.tanh,
    ca.OP_FABS: abs,
    ca.OP_FMIN: arb.min,
    ca.OP_FMAX: arb.max,
}


class BentEnclosure(Enclosure):
    """Second derivatives of a graph where it has one formula: value and slopes are looked at, too.

    A box on which any of the three leaves a condition open, or has a kink, is refused.
    """

    def __init__(self, name: str, inputs: Sequence[ca.SX], output: ca.SX, by: ca.SX) -> None:
        """Differentiate ``output`` twice by ``by``; ``bends`` (output, variable, variable)."""
        slope = ca.jacobian(output, by)
        bent = ca.jacobian(ca.vec(slope.nz[:]), by)
        first = list(zip(*slope.sparsity().get_triplet(), strict=True))
        pairs = zip(*bent.sparsity().get_triplet(), strict=True)
        self.bends = [(*first[k], j) for k, j in pairs]
        every = (ca.vec(part.nz[:]) for part in (bent, slope, output))
        super().__init__(name, inputs, ca.vertcat(*every))

    def __call__(self, *values: Balls) -> Balls:
        """The second derivatives in the order of ``bends``."""
        return super().__call__(*values)[: len(self.bends)]


def upper(value: arb) -> float:
    """A double that is at least the size of every number in the ball."""
    return float(value.abs_upper()) * (1 + 2**-50)
