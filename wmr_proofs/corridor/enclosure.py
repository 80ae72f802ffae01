"""Graphs in balls: python-flint's midpoint and radius arithmetic, rounded outwards.

It evaluates the graph that C is made from (`wmr_ctrl.world.model.graph`).  A condition that a ball
does not decide is not guessed: `OpenBoxError` names the graph.
"""

import operator
from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache, partial
from typing import cast

import casadi as ca
from flint import arb

from wmr_ctrl.world.model.graph import SELECT, Node, read

Balls = list[arb]
OFTEN = 3
"""Calls after which a graph becomes one Python function, which takes some calls' time."""


class OpenBoxError(ArithmeticError):
    """A ball does not decide a condition, or leaves an operation's domain."""


class Enclosure:
    """A CasADi expression of named columns, evaluated in balls."""

    def __init__(self, name: str, inputs: Sequence[ca.SX], output: ca.SX) -> None:
        """Read the graph; only the non-zero entries of ``output`` are evaluated."""
        self.pattern = list(zip(*output.sparsity().get_triplet(), strict=True))
        function = ca.Function("enclosed", list(inputs), [output.nz[:]])
        self._program = _program(name, function.serialize())

    def __call__(self, *values: Balls) -> Balls:
        """The output's entries in the order of ``pattern`` (row, column)."""
        return self._program(values)


class _Program:
    """Evaluator of a graph, shared by all loops that have the same one."""

    def __init__(self, name: str, function: ca.Function) -> None:
        places = [f"i{k}" for k in range(function.n_in())]
        self.name = name
        graph = read(function, places, ("y",))
        self._constants = [arb(node.number) for node in graph.nodes if node.op == ca.OP_CONST]
        known = [k for k, node in enumerate(graph.nodes) if node.op == ca.OP_CONST]
        self._inputs = [
            (places.index(node.place[0]), node.place[1])
            for node in graph.nodes if node.place is not None
        ]  # fmt: skip
        known += [k for k, node in enumerate(graph.nodes) if node.place is not None]
        place = {k: n for n, k in enumerate(known)}
        self._steps = list[tuple[Callable[..., arb], list[int]]]()
        for k, node in enumerate(graph.nodes):
            if k not in place:
                place[k] = len(place)
                self._steps.append((self._operation(node), [place[i] for i in node.operands]))
        stores = {store.index: store.node for store in graph.stores}
        self._stores = [place[stores[k]] for k in range(len(stores))]
        self._calls = 0

    def __call__(self, values: Sequence[Balls]) -> Balls:
        self._calls += 1
        given = [*self._constants, *(values[place][index] for place, index in self._inputs)]
        results = self._at_once(given) if self._calls > OFTEN else self._by_steps(given)
        if not all(map(arb.is_finite, results)):
            raise OpenBoxError(f"{self.name}: an operation leaves its domain")
        return results

    def _by_steps(self, done: Balls) -> Balls:
        for operation, operands in self._steps:
            done.append(operation(*[done[i] for i in operands]))
        return [done[k] for k in self._stores]

    @cached_property
    def _at_once(self) -> Callable[[Balls], Balls]:
        """The whole program as one Python function of constants and inputs."""
        count = len(self._constants) + len(self._inputs)
        lines = [f"[{', '.join(f'x{k}' for k in range(count))}] = given"]
        operations = dict[str, Callable[..., arb]]()
        for k, (operation, operands) in enumerate(self._steps):
            names = [f"x{i}" for i in operands]
            value = f" {_SIGNS.get(operation)} ".join(names)
            if operation not in _SIGNS:
                operations[f"f{k}"], value = operation, f"f{k}({', '.join(names)})"
            lines.append(f"x{count + k} = {value}")
        lines.append(f"return [{', '.join(f'x{k}' for k in self._stores)}]")
        exec("def at_once(given):\n    " + "\n    ".join(lines), space := {**operations})
        return cast("Callable[[Balls], Balls]", space["at_once"])

    def _operation(self, node: Node) -> Callable[..., arb]:
        op = node.op
        if op == SELECT:
            return lambda c, a, b: a if self._decided(op, c != 0, c == 0) else b
        if op in _CONDITIONS:
            return lambda *given: arb(int(self._decided(op, *_CONDITIONS[op](*given))))
        if op == ca.OP_SIGN:
            return lambda a: arb(1 if self._decided(op, a > 0, a < 0) else -1)
        return _OPERATIONS.get(op, partial(self._uncovered, op))

    def _uncovered(self, op: int, *_: arb) -> arb:
        raise OpenBoxError(f"{self.name}: operation {op} of CasADi is not covered")

    def _decided(self, op: int, yes: bool, no: bool) -> bool:
        if yes == no:
            raise OpenBoxError(f"{self.name}: a condition (operation {op}) cannot be decided")
        return yes


@lru_cache(maxsize=64)
def _program(name: str, serialized: str) -> _Program:
    return _Program(name, ca.Function.deserialize(serialized))


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
    ca.OP_ADD: operator.add,
    ca.OP_SUB: operator.sub,
    ca.OP_MUL: operator.mul,
    ca.OP_DIV: operator.truediv,
    ca.OP_INV: lambda a: 1 / a,
    ca.OP_NEG: operator.neg,
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


_SIGNS = {operator.add: "+", operator.sub: "-", operator.mul: "*", operator.truediv: "/"}


class BentEnclosure(Enclosure):
    """Second derivatives of a graph, valid only where value and gradient also have one formula.

    A box is refused if any of the three has an undecided condition or a kink on it.
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
    """A double that is at least the absolute value of every number in the ball."""
    return float(value.abs_upper()) * (1 + 2**-50)
