"""Rounding: what doubles make of a graph, as a statement over the real numbers.

Every operation that rounds becomes an input of its own, any number that is within the unit of
rounding of the exact result of that operation on numbers so computed: the standard model of IEEE
arithmetic without overflow and underflow.  What is shown of all such numbers is shown of the
compiled text (`assumption.libm`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import frexp

from wmr_ctrl.proofs.graph import LOGICAL, ProvedGraph, ProvedNode

UNIT = 2.0**-53
"""Largest relative error of one operation in double precision."""

EXACT = LOGICAL | {"const", "input", "neg", "fabs", "fmin", "fmax", "choose", "twice", "sign"}
ROUNDED = frozenset({"add", "sub", "mul", "div", "inv", "sq", "sqrt"})


@dataclass(frozen=True)
class RoundedGraph:
    """Nodes with an input for each rounding, where each result is, and what bounds the inputs.

    ``bounds`` are nodes that are not negative: the unit's share of an exact result, less how far
    the computed one is from it, either way.
    """

    nodes: tuple[ProvedNode, ...]
    outputs: tuple[int, ...]
    bounds: tuple[int, ...]


def rounded(graph: ProvedGraph, unit: float) -> RoundedGraph:
    """``graph`` as doubles compute it.  ValueError where an operation's error is not known."""
    nodes: list[ProvedNode] = []
    place: list[int] = []
    bounds: list[int] = []

    def put(node: ProvedNode) -> int:
        nodes.append(node)
        return len(nodes) - 1

    for node in graph.nodes:
        exact = put(ProvedNode(node.op, tuple(place[k] for k in node.args), node.value, node.name))
        if node.op in EXACT or _scales(node, graph):
            place.append(exact)
            continue
        if node.op not in ROUNDED:
            raise ValueError(f"how far {node.op} is rounded is not known")
        found = put(ProvedNode("input", name=f"rounded {len(bounds) // 2 + 1}"))
        share = put(ProvedNode("mul", (put(ProvedNode("const", value=unit)),
                                       put(ProvedNode("fabs", (exact,))))))  # fmt: skip
        for pair in ((found, exact), (exact, found)):
            bounds.append(put(ProvedNode("sub", (share, put(ProvedNode("sub", pair))))))
        place.append(found)
    return RoundedGraph(tuple(nodes), tuple(place[k] for k in graph.outputs), tuple(bounds))


def _scales(node: ProvedNode, graph: ProvedGraph) -> bool:
    """Whether it is a product with a power of two, which is exact."""
    factors = (graph.nodes[k] for k in node.args)
    return node.op == "mul" and any(
        item.op == "const" and abs(frexp(item.value)[0]) == 0.5 for item in factors
    )


def linked(graph: ProvedGraph, parts: RoundedGraph, names: Sequence[str]) -> ProvedGraph:
    """``graph`` with the computed results in the place of its inputs of these ``names``.

    Its outputs, and behind them the bounds of all roundings.
    """
    results = dict(zip(names, parts.outputs, strict=True))
    nodes = list(parts.nodes)
    place: list[int] = []
    for node in graph.nodes:
        if node.op == "input" and node.name in results:
            place.append(results[node.name])
            continue
        args = tuple(place[k] for k in node.args)
        nodes.append(ProvedNode(node.op, args, node.value, node.name))
        place.append(len(nodes) - 1)
    return ProvedGraph(tuple(nodes), (*(place[k] for k in graph.outputs), *parts.bounds))
