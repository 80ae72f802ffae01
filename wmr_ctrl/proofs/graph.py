"""Graph: what is compiled, as a list of nodes that any method of proof can walk.

The nodes are those of `wmr_ctrl.model.graph`, which the emitter of C is given: a choice is one node
``choose``, so that a method never looks at a branch that is not taken, and a quotient by a
parameter is the product that C computes.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca

import wmr_ctrl.model.graph as compiled_graph

_NAMES = {
    **{getattr(ca, name): name[3:].lower() for name in dir(ca) if name.startswith("OP_")},
    compiled_graph.SELECT: "choose",
}
LOGICAL = frozenset(_NAMES[op] for op in compiled_graph.LOGICAL)


@dataclass(frozen=True, slots=True)
class ProvedNode:
    """One operation: its name, the nodes it reads, its constant or the name of its input."""

    op: str
    args: tuple[int, ...] = ()
    value: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class ProvedGraph:
    """Nodes in an order of evaluation, and the node of each output."""

    nodes: tuple[ProvedNode, ...]
    outputs: tuple[int, ...]

    @cached_property
    def logical(self) -> frozenset[int]:
        """Nodes whose value is a truth."""
        return frozenset(k for k, node in enumerate(self.nodes) if node.op in LOGICAL)

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
    inputs: Mapping[str, ca.SX],
    outputs: Sequence[ca.SX],
    cuts: Mapping[str, ca.SX] | None = None,
    numbers: Mapping[str, float] | None = None,
) -> ProvedGraph:
    """ProvedGraph of scalar expressions in named scalar symbols, as the compiler is given it.

    A cut replaces the node that computes its expression by an input of that name (a constant
    stays: the same number may stand elsewhere for something else); ``numbers`` are
    values of inputs.  Both are put in after the graph was read, so what is left is the compiled
    text.  ValueError where an output still depends on a symbol that is not named.
    """
    cut = dict(cuts or {})
    symbols = {symbol.element_hash() for symbol in inputs.values()}
    every = ca.symvar(ca.vertcat(*outputs, *cut.values()))
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
    free = [name for name in graph.input_names if name.startswith("?")]
    if free:
        raise ValueError(
            f"the graph depends on {', '.join(free)}, which the statement does not name"
        )
    return _compact(graph)


def is_parameter(symbol: ca.SX) -> bool:
    """True if a symbol stands for a number of the scenario: those have a dotted key."""
    return "." in symbol.name()


def _compiled(
    given: Mapping[str, ca.SX], exprs: Sequence[ca.SX]
) -> tuple[compiled_graph.Graph, list[int]]:
    """Graph as the emitter gets it, with the place of every symbol in ``given`` kept."""
    groups = {False: ca.SX.zeros(len(given)), True: ca.SX.zeros(len(given))}
    for row, symbol in enumerate(given.values()):
        for group in groups:
            kept = is_parameter(symbol) == group
            groups[group][row] = symbol if kept else ca.SX.sym("unused")
    function = ca.Function("graph", [groups[False], groups[True]], [ca.densify(ca.vertcat(*exprs))])
    graph = compiled_graph.read(function, ("x", compiled_graph.PARAMETERS), ("y",))
    return graph, [store.node for store in sorted(graph.stores, key=lambda store: store.index)]


def _named(node: compiled_graph.Node, names: Sequence[str]) -> ProvedNode:
    if node.place is not None:
        return ProvedNode("input", name=names[node.place[1]])
    return ProvedNode(_NAMES[node.op], node.operands, node.number)


def _compact(graph: ProvedGraph) -> ProvedGraph:
    """Only the nodes that an output needs, in an order fixed by the outputs alone."""
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
        nodes.append(
            ProvedNode(node.op, tuple(place[arg] for arg in node.args), node.value, node.name)
        )
    return ProvedGraph(tuple(nodes), tuple(place[k] for k in graph.outputs))
