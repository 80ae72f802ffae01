"""Graph: a CasADi function as a list of nodes that any method of proof can walk.

The nodes are the instructions of the very function that code generation reads, after common
subexpressions were merged.  ``(c ? a : 0) + (!c ? b : 0)``, which is how an if_else arrives, is
made one node ``choose``, so that a method never looks at a branch that is not taken.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

_NAMES = {getattr(ca, name): name[3:].lower() for name in dir(ca) if name.startswith("OP_")}
LOGICAL = frozenset({"lt", "le", "eq", "ne", "and", "or", "not"})


@dataclass(frozen=True, slots=True)
class Node:
    """One operation: its name, the nodes it reads, its constant or the name of its input."""

    op: str
    args: tuple[int, ...] = ()
    value: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class Graph:
    """Nodes in an order of evaluation, and the node of each output."""

    nodes: tuple[Node, ...]
    outputs: tuple[int, ...]

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs that an output depends on."""
        used = self._reached()
        named = (item.name for k, item in enumerate(self.nodes) if item.op == "input" and k in used)
        return tuple(dict.fromkeys(named))

    @property
    def digest(self) -> str:
        """sha256 of what the outputs depend on, with constants to the bit."""
        used = self._reached()
        rows = [
            f"{k} {n.op} {n.args} {float(n.value).hex()} {n.name}"
            for k, n in enumerate(self.nodes)
            if k in used
        ]
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
    inputs: Mapping[str, ca.SX], outputs: Sequence[ca.SX], cuts: Mapping[str, ca.SX] | None = None
) -> Graph:
    """Graph of scalar expressions in named scalar symbols.

    A cut replaces the node that computes its expression by an input of that name.  ValueError where
    an output still depends on a symbol that is not named.
    """
    cut_names = list(cuts or {})
    scalars = [*outputs, *(cuts or {}).values()]
    loose = [
        s
        for s in ca.symvar(ca.vertcat(*scalars))
        if not any(ca.is_equal(s, known) for known in inputs.values())
    ]
    shared = ca.cse([ca.vertcat(*scalars)])
    given = ca.vertcat(*inputs.values(), *loose)
    names = [*inputs, *(f"?{symbol.name()}" for symbol in loose)]
    reader = _Reader(ca.Function("graph", [given], shared), names)
    nodes, found = reader.read(len(scalars))
    wanted = tuple(found[: len(outputs)])
    for name, node in zip(cut_names, found[len(outputs) :], strict=True):
        nodes[node] = Node("input", name=name)
    graph = Graph(tuple(nodes), wanted)
    free = [name for name in graph.input_names if name.startswith("?")]
    if free:
        raise ValueError(
            f"the graph depends on {', '.join(free)}, which the statement does not name"
        )
    return _compact(graph)


class _Reader:
    """Instructions with reused work slots to single-assignment nodes."""

    def __init__(self, function: ca.Function, names: Sequence[str]) -> None:
        self.function, self.names = function, names
        self.nodes: list[Node] = []
        self.slot: dict[int, int] = {}
        self.known: dict[Node, int] = {}

    def read(self, count: int) -> tuple[list[Node], list[int]]:
        """All nodes and the node of each of the ``count`` outputs."""
        found = [0] * count
        zero = self._node(Node("const"))
        found = [zero] * count
        for k in range(self.function.n_instructions()):
            op = _NAMES[self.function.instruction_id(k)]
            into, operands = self.function.instruction_output(k), self.function.instruction_input(k)
            if op == "output":
                found[into[1]] = self.slot[operands[0]]
            else:
                self.slot[into[0]] = self._read(k, op, operands)
        return self.nodes, found

    def _read(self, k: int, op: str, operands: Sequence[int]) -> int:
        if op == "const":
            return self._node(Node("const", value=self.function.instruction_constant(k)))
        if op == "input":
            return self._node(Node("input", name=self.names[operands[1]]))
        args = tuple(self.slot[i] for i in operands)
        return self._choice(op, args) or self._node(Node(op, args))

    def _choice(self, op: str, args: tuple[int, ...]) -> int | None:
        """Node of a whole if_else, or of a lone half of one."""
        if op == "if_else_zero":
            return self._node(Node("choose", (args[0], args[1], self._node(Node("const")))))
        if op != "add":
            return None
        halves = [self.nodes[arg] for arg in args]
        if any(half.op != "choose" or self.nodes[half.args[2]] != Node("const") for half in halves):
            return None
        for first, second in (halves, halves[::-1]):
            if self.nodes[second.args[0]] == Node("not", (first.args[0],)):
                return self._node(Node("choose", (first.args[0], first.args[1], second.args[1])))
        return None

    def _node(self, node: Node) -> int:
        key = Node(node.op, node.args, float(node.value), node.name)
        if key not in self.known or str(node.value) == "nan":
            self.nodes.append(key)
            self.known[key] = len(self.nodes) - 1
        return self.known[key]


def _compact(graph: Graph) -> Graph:
    """Only the nodes that an output needs, in an order fixed by the outputs alone."""
    place: dict[int, int] = {}
    nodes: list[Node] = []
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
        nodes.append(Node(node.op, tuple(place[arg] for arg in node.args), node.value, node.name))
    return Graph(tuple(nodes), tuple(place[k] for k in graph.outputs))
