"""The compiled function as a list of nodes, and the walker that evaluates it.

The nodes are those of `wmr_ctrl.world.model.graph`, which the C emitter also uses: a choice is one
node ``choose``, so that a method never evaluates a branch that is not taken, and a quotient by a
parameter is the product that C computes.

A method of proof is an `Arithmetic`: constants, inputs, operations and, for conditions, either a
decision or a merge.  If a condition cannot be decided the walk takes both paths, one after the
other, and the claim must be proved on each.
"""

import hashlib
import operator
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol, TypeAlias

import casadi as ca
from casadi import SX, vertcat

import wmr_ctrl.world.model.graph as compiled_graph

Expressions: TypeAlias = Mapping[str, SX]
"""Expressions by name."""
Ask: TypeAlias = Callable[[Hashable], bool]
"""Decides a condition that an arithmetic cannot decide."""
_NAMES = {
    **{getattr(ca, name): name[3:].lower() for name in dir(ca) if name.startswith("OP_")},
    compiled_graph.SELECT: "choose",
}
LOGICAL = frozenset(_NAMES[op] for op in compiled_graph.LOGICAL)


class ProvedNode(NamedTuple):
    """One operation: its name, the nodes it reads, its constant or the name of its input."""

    op: str
    args: tuple[int, ...] = ()
    value: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class ProvedGraph:
    """Nodes in order of evaluation, and the node of each output."""

    nodes: tuple[ProvedNode, ...]
    outputs: tuple[int, ...]

    @cached_property
    def logical(self) -> frozenset[int]:
        """Nodes whose value is a truth value."""
        return frozenset(k for k, node in enumerate(self.nodes) if node.op in LOGICAL)

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs that an output depends on."""
        used = self._reached()
        named = (item.name for k, item in enumerate(self.nodes) if item.op == "input" and k in used)
        return tuple(dict.fromkeys(named))

    @property
    def digest(self) -> str:
        """sha256 of the nodes that the outputs depend on, with constants to the bit."""
        used = self._reached()
        numbered = ((k, n) for k, n in enumerate(self.nodes) if k in used)
        rows = [f"{k} {n.op} {n.args} {float(n.value).hex()} {n.name}" for k, n in numbered]
        return hashlib.sha256("\n".join([*rows, str(self.outputs)]).encode()).hexdigest()

    def _reached(self) -> set[int]:
        found: set[int] = set()
        stack = list(self.outputs)
        while stack:
            k = stack.pop()
            if k not in found:
                found.add(k)
                stack.extend(self.nodes[k].args)
        return found


def graph_of(
    inputs: Expressions,
    outputs: Sequence[SX],
    cuts: Expressions | None = None,
    numbers: Mapping[str, float] | None = None,
) -> ProvedGraph:
    """ProvedGraph of scalar expressions in named scalar symbols, as the compiler receives it.

    A cut replaces the node of its expression by an input of that name (a constant is not replaced:
    the same number may have another meaning elsewhere); ``numbers`` are values of inputs.  Both are
    substituted after the graph was read, so the rest is the compiled text.  ValueError if an output
    depends on an unnamed symbol.
    """
    cut = dict(cuts or {})
    symbols = {symbol.element_hash() for symbol in inputs.values()}
    every = ca.symvar(vertcat(*outputs, *cut.values()))
    unnamed = {f"?{one.name()}": one for one in every if one.element_hash() not in symbols}
    given = {**inputs, **unnamed}
    compiled, places = _compiled(given, (*outputs, *cut.values()))
    nodes = [_named(node, list(given)) for node in compiled.nodes]
    for name, place in zip(cut, places[len(outputs) :], strict=True):
        if nodes[place].op != "const":
            nodes[place] = ProvedNode("input", name=name)
    known = numbers or {}
    nodes = [ProvedNode("const", value=known[n.name]) if n.name in known else n for n in nodes]
    graph = ProvedGraph(tuple(nodes), tuple(places[: len(outputs)]))
    free = ", ".join(name for name in graph.input_names if name.startswith("?"))
    if free:
        raise ValueError(f"the graph depends on {free}, which the statement does not name")
    return _compact(graph)


def is_parameter(symbol: SX) -> bool:
    """True if a symbol is a number of the scenario: those have dotted keys."""
    return "." in symbol.name()


def _compiled(given: Expressions, exprs: Sequence[SX]) -> tuple[compiled_graph.Graph, list[int]]:
    """Graph for the emitter, with the index of every symbol in ``given`` preserved."""
    groups = {False: SX.zeros(len(given)), True: SX.zeros(len(given))}
    for row, symbol in enumerate(given.values()):
        for group in groups:
            kept = is_parameter(symbol) == group
            groups[group][row] = symbol if kept else SX.sym("unused")
    function = ca.Function("graph", [groups[False], groups[True]], [ca.densify(vertcat(*exprs))])
    graph = compiled_graph.read(function, ("x", compiled_graph.PARAMETERS), ("y",))
    return graph, [store.node for store in sorted(graph.stores, key=lambda store: store.index)]


def _named(node: compiled_graph.Node, names: Sequence[str]) -> ProvedNode:
    if node.place is not None:
        return ProvedNode("input", name=names[node.place[1]])
    return ProvedNode(_NAMES[node.op], node.operands, node.number)


def _compact(graph: ProvedGraph) -> ProvedGraph:
    """The nodes that an output needs, in an order that depends on the outputs alone."""
    place: dict[int, int] = {}
    nodes: list[ProvedNode] = []
    stack = [(k, False) for k in reversed(graph.outputs)]
    while stack:
        k, ready = stack.pop()
        if k in place:
            continue
        node = graph.nodes[k]
        if not ready:
            stack.append((k, True))
            stack.extend((arg, False) for arg in reversed(node.args))
            continue
        place[k] = len(nodes)
        nodes.append(node._replace(args=tuple(place[arg] for arg in node.args)))
    return ProvedGraph(tuple(nodes), tuple(place[k] for k in graph.outputs))


COMPARISONS = frozenset({"lt", "le", "eq", "ne"})
NO_OPERATION = frozenset({"const", "input", "choose"}) | COMPARISONS | LOGICAL


class UndecidedError(ArithmeticError):
    """A condition or a domain that a method cannot decide; goals that depend on it remain open."""


class Arithmetic(Protocol):
    """Arithmetic of a proof method."""

    def constant(self, value: float) -> Any:
        """Value of a constant of the graph."""

    def variable(self, name: str) -> Any:
        """Value of an input."""

    def apply(self, op: str, args: list[Any]) -> Any:
        """Value of an arithmetic operation."""

    def compare(self, op: str, left: Any, right: Any, ask: Ask) -> Any:
        """Truth of ``lt``, ``le``, ``eq`` or ``ne``; ``ask`` decides what the arithmetic cannot."""

    def logic(self, op: str, args: list[Any]) -> Any:
        """Truth of ``and``, ``or`` or ``not``: Python's logic, for conditions that are bools."""
        return not args[0] if op == "not" else (all(args) if op == "and" else any(args))

    def merge(self, condition: Any, yes: Any, no: Any) -> Any:
        """Value of a choice whose condition is a term; not called if conditions are decided."""
        raise UndecidedError(f"a choice by {condition} between {yes} and {no}")

    def number(self, condition: Any) -> Any:
        """A truth value used as the number 1 or 0."""


class Walk:
    """One evaluation of a graph along decided conditions, of the needed nodes only."""

    def __init__(self, graph: ProvedGraph, arithmetic: Arithmetic, ask: Ask) -> None:
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
        """A condition; as in C, a number is true if it is not 0."""
        if k in self.graph.logical:
            return self.values[k]
        if k not in self.truths:
            zero = self.arithmetic.constant(0.0)
            self.truths[k] = self.arithmetic.compare("ne", self.values[k], zero, self.ask)
        return self.truths[k]

    def _numbers(self, args: tuple[int, ...]) -> list[Any]:
        values, logical, number = self.values, self.graph.logical, self.arithmetic.number
        return [number(values[k]) if k in logical else values[k] for k in args]


def paths(run: Callable[[Ask], Any], limit: int = 64) -> Iterator[tuple[dict[Hashable, bool], Any]]:
    """Results of ``run(ask)`` on every path through the undecided conditions.

    UndecidedError if there are more than ``limit`` paths.
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


COMPARE = {name: getattr(operator, name) for name in COMPARISONS}
ARITHMETIC: dict[str, Callable[..., Any]] = {
    **{name: getattr(operator, name) for name in ("add", "sub", "mul", "neg")},
    "div": operator.truediv,
    "inv": lambda a: 1 / a,
    "sq": lambda a: a * a,
    "twice": lambda a: 2 * a,
    "assign": lambda a: a,
}
"""Operations by the walker's names; a backend adds its own."""
