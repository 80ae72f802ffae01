"""The one walker: it evaluates a graph in whatever arithmetic a method brings.

A method is an `Arithmetic`: constants, inputs, operations and, for conditions, either a decision or
a merge.  Where a condition cannot be decided the walk takes both ways, one after the other, and
what is to be shown must hold on each.
"""

from collections.abc import Callable, Hashable, Iterator
from typing import Any, Protocol

from wmr_ctrl.proofs.graph import LOGICAL, ProvedGraph, ProvedNode

COMPARISONS = frozenset({"lt", "le", "eq", "ne"})
NO_OPERATION = frozenset({"const", "input", "choose"}) | COMPARISONS | LOGICAL


class UndecidedError(ArithmeticError):
    """A condition or a domain that a method cannot settle: what rests on it stays open."""


class Arithmetic(Protocol):
    """Arithmetic of a proof method."""

    def constant(self, value: float) -> Any:
        """Value of a constant of the graph."""

    def variable(self, name: str) -> Any:
        """Value of an input."""

    def apply(self, op: str, args: list[Any]) -> Any:
        """Value of an arithmetic operation."""

    def compare(self, op: str, left: Any, right: Any, ask: Callable[[Hashable], bool]) -> Any:
        """Truth of ``lt``, ``le``, ``eq`` or ``ne``; ``ask`` decides what the arithmetic cannot."""

    def logic(self, op: str, args: list[Any]) -> Any:
        """Truth of ``and``, ``or`` or ``not``: plain logic, where conditions are plain bools."""
        return not args[0] if op == "not" else (all(args) if op == "and" else any(args))

    def merge(self, condition: Any, yes: Any, no: Any) -> Any:
        """Value of a choice whose condition is a term: never, where conditions are decided."""
        raise UndecidedError(f"a choice by {condition} between {yes} and {no}")

    def number(self, condition: Any) -> Any:
        """A truth value used as the number 1 or 0."""


class Walk:
    """One evaluation of a graph along decided conditions, only of what is needed."""

    def __init__(
        self, graph: ProvedGraph, arithmetic: Arithmetic, ask: Callable[[Hashable], bool]
    ) -> None:
        self.graph, self.arithmetic, self.ask = graph, arithmetic, ask
        self.values: dict[int, Any] = {}
        self.truths: dict[int, Any] = {}

    def outputs(self) -> list[Any]:
        """Values of all outputs."""
        for k in self.graph.outputs:
            self._evaluate(k)
        return self._numbers(self.graph.outputs)

    def _evaluate(self, root: int) -> None:
        nodes, values, stack = self.graph.nodes, self.values, [root]
        while stack:
            k = stack[-1]
            if k in values:
                stack.pop()
                continue
            node = nodes[k]
            wanted = node.args if node.op != "choose" else self._wanted(node.args)
            missing = [arg for arg in wanted if arg not in values]
            if missing:
                stack.extend(missing)
            else:
                values[k] = self._compute(node)

    def _wanted(self, args: tuple[int, ...]) -> tuple[int, ...]:
        """Operands of a choice that are needed now: first the condition, then the branch taken."""
        if args[0] not in self.values:
            return args[:1]
        truth = self.truth(args[0])
        return args if not isinstance(truth, bool) else (args[1 if truth else 2],)

    def _compute(self, node: ProvedNode) -> Any:
        op, arithmetic = node.op, self.arithmetic
        if op not in NO_OPERATION:
            return arithmetic.apply(op, self._numbers(node.args))
        if op == "const":
            return arithmetic.constant(node.value)
        if op == "input":
            return arithmetic.variable(node.name)
        if op == "choose":
            return self._choose(node.args)
        if op in COMPARISONS:
            left, right = self._numbers(node.args)
            return arithmetic.compare(op, left, right, self.ask)
        return arithmetic.logic(op, [self.truth(arg) for arg in node.args])

    def _choose(self, args: tuple[int, ...]) -> Any:
        truth = self.truth(args[0])
        if isinstance(truth, bool):
            return self._numbers((args[1 if truth else 2],))[0]
        return self.arithmetic.merge(truth, *self._numbers(args[1:]))

    def truth(self, k: int) -> Any:
        """A condition; a number counts as true where it is not 0, as in C."""
        if k in self.graph.logical:
            return self.values[k]
        if k not in self.truths:
            zero = self.arithmetic.constant(0.0)
            self.truths[k] = self.arithmetic.compare("ne", self.values[k], zero, self.ask)
        return self.truths[k]

    def _numbers(self, args: tuple[int, ...]) -> list[Any]:
        values, logical, number = self.values, self.graph.logical, self.arithmetic.number
        return [number(values[k]) if k in logical else values[k] for k in args]


def paths(
    run: Callable[[Callable[[Hashable], bool]], Any], limit: int = 64
) -> Iterator[tuple[dict[Hashable, bool], Any]]:
    """Results of ``run(ask)`` on every way through the undecided conditions.

    UndecidedError where there are more than ``limit`` ways.
    """
    pending: list[dict[Hashable, bool]] = [{}]
    done = 0
    while pending:
        taken = dict(pending.pop())

        def ask(key: Hashable, taken: dict[Hashable, bool] = taken) -> bool:
            if key not in taken:
                pending.append({**taken, key: False})
                taken[key] = True
            return taken[key]

        done += 1
        if done > limit:
            raise UndecidedError(f"more than {limit} ways through undecided conditions")
        yield taken, run(ask)


ARITHMETIC: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "inv": lambda a: 1 / a,
    "neg": lambda a: -a,
    "sq": lambda a: a * a,
    "twice": lambda a: 2 * a,
    "assign": lambda a: a,
}
"""By the walker's name of the operation; a backend adds what is its own."""
