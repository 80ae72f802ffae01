"""The one walker: it evaluates a graph in whatever arithmetic a method brings.

A method is an `Arithmetic`: constants, inputs, operations and, for conditions, either a decision or
a merge.  Where a condition cannot be decided the walk takes both ways, one after the other, and
what is to be shown must hold on each.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from typing import Any, Protocol

from wmr_ctrl.proofs.graph import LOGICAL, ProvedGraph


class UndecidedError(ArithmeticError):
    """A condition or a domain that a method cannot settle: what rests on it stays open."""


class Arithmetic(Protocol):
    """What a method of proof brings."""

    def constant(self, value: float) -> Any:
        """Value of a constant of the graph."""

    def variable(self, name: str) -> Any:
        """Value of an input."""

    def apply(self, op: str, args: list[Any]) -> Any:
        """Value of an arithmetic operation."""

    def compare(self, op: str, left: Any, right: Any, ask: Callable[[Hashable], bool]) -> Any:
        """Truth of ``lt``, ``le``, ``eq`` or ``ne``; ``ask`` decides what the arithmetic cannot."""

    def logic(self, op: str, args: list[Any]) -> Any:
        """Truth of ``and``, ``or`` or ``not``."""

    def merge(self, condition: Any, yes: Any, no: Any) -> Any:
        """Value of a choice whose condition is a term, not a plain bool."""

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
        return [self._numeric(k) for k in self.graph.outputs]

    def _evaluate(self, root: int) -> None:
        nodes, values, stack = self.graph.nodes, self.values, [root]
        while stack:
            k = stack[-1]
            wanted = nodes[k].args if nodes[k].op != "choose" else self._wanted(k)
            missing = [arg for arg in wanted if arg not in values]
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            if k not in values:
                values[k] = self._compute(k)

    def _wanted(self, k: int) -> tuple[int, ...]:
        """Operands of a choice that are needed now: first the condition, then the branch taken."""
        node = self.graph.nodes[k]
        if node.args[0] not in self.values:
            return node.args[:1]
        truth = self.truth(node.args[0])
        return node.args if not isinstance(truth, bool) else (node.args[1 if truth else 2],)

    def _compute(self, k: int) -> Any:
        node = self.graph.nodes[k]
        if node.op == "const":
            return self.arithmetic.constant(node.value)
        if node.op == "input":
            return self.arithmetic.variable(node.name)
        if node.op == "choose":
            return self._choose(node.args)
        if node.op in ("lt", "le", "eq", "ne"):
            left, right = (self._numeric(arg) for arg in node.args)
            return self.arithmetic.compare(node.op, left, right, self.ask)
        if node.op in LOGICAL:
            return self.arithmetic.logic(node.op, [self.truth(arg) for arg in node.args])
        return self.arithmetic.apply(node.op, [self._numeric(arg) for arg in node.args])

    def _choose(self, args: tuple[int, ...]) -> Any:
        truth = self.truth(args[0])
        if isinstance(truth, bool):
            return self._numeric(args[1 if truth else 2])
        return self.arithmetic.merge(truth, self._numeric(args[1]), self._numeric(args[2]))

    def truth(self, k: int) -> Any:
        """A condition; a number counts as true where it is not 0, as in C."""
        if self.graph.nodes[k].op in LOGICAL:
            return self.values[k]
        if k not in self.truths:
            zero = self.arithmetic.constant(0.0)
            self.truths[k] = self.arithmetic.compare("ne", self.values[k], zero, self.ask)
        return self.truths[k]

    def _numeric(self, k: int) -> Any:
        value = self.values[k]
        return self.arithmetic.number(value) if self.graph.nodes[k].op in LOGICAL else value


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
