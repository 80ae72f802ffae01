"""What a kernel takes of the parameters alone is computed when they are set, where it is slow."""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.model.graph import CHANGING, STEADY, Graph, Node, Store, kinds, without_unused

PREPARED = "c"
"""Name of the vector of prepared values."""


def split(graph: Graph) -> tuple[Graph, Graph]:
    """The graph of slow values of parameters alone, and the graph that reads them as a vector.

    Slow: a division, root or function stands somewhere in the value.  Together they compute what
    the whole does, in the same bits.
    """
    wanted = _wanted(graph)
    before = [Store(PREPARED, index, number) for index, number in enumerate(wanted)]
    places = {number: (PREPARED, index) for index, number in enumerate(wanted)}
    read = [
        Node(ca.OP_INPUT, place=places[number]) if number in places else node
        for number, node in enumerate(graph.nodes)
    ]
    return (
        without_unused(list(graph.nodes), before),
        without_unused(read, list(graph.stores)),
    )


def _wanted(graph: Graph) -> list[int]:
    """Slow steady values that something changing, or a result, reads."""
    kind, slow = kinds(graph.nodes), _slow(graph)
    readers = [node for number, node in enumerate(graph.nodes) if kind[number] == CHANGING]
    read = {number for node in readers for number in node.operands}
    read |= {store.node for store in graph.stores}
    return sorted(
        number
        for number in read
        if kind[number] == STEADY and slow[number] and not graph.is_logical(number)
    )


def _slow(graph: Graph) -> list[bool]:
    found: list[bool] = []
    for number, node in enumerate(graph.nodes):
        found.append(graph.cost(number) > 1 or any(found[k] for k in node.operands))
    return found
