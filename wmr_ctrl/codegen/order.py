"""Order of statements: long ways go on side by side.

A processor looks ahead through so many statements only.  Of ways that stand one after the other it
follows one at a time, however independent they are; side by side they take the time of one.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import casadi as ca

from wmr_ctrl.codegen.items import IfElse, Item, Operation, Pair
from wmr_ctrl.model.graph import SELECT, Graph

WAITS = {
    ca.OP_EXPM1: 50, ca.OP_DIV: 14, ca.OP_ADD: 3, ca.OP_SUB: 3, ca.OP_NEG: 1, ca.OP_FABS: 1,
    ca.OP_LT: 1, ca.OP_LE: 1, ca.OP_AND: 1, SELECT: 1, None: 2,
}  # fmt: skip
"""Cycles, roughly, until an operation's result is there; 4 of those that are not listed."""


def in_step(graph: Graph, items: Sequence[Item]) -> list[Item]:
    """The items of a scope by how long the way from each to the scope's end is, longest first."""
    left, start = dict[int, int](), dict[Item, int]()
    for item in reversed(items):
        behind = max((left.get(number, 0) for number in item.defines), default=0)
        start[item] = _waits(graph, item) + behind
        for number in item.reads:
            left[number] = max(left.get(number, 0), start[item])
    found = sorted(items, key=lambda item: -start[item])
    return [_inside(graph, item) if isinstance(item, IfElse) else item for item in found]


def _inside(graph: Graph, item: IfElse) -> IfElse:
    then, other = (tuple(in_step(graph, side)) for side in (item.then, item.other))
    return replace(item, then=then, other=other)


def _waits(graph: Graph, item: Item) -> int:
    """Cycles that readers of an item wait for it."""
    if isinstance(item, IfElse):
        return max(_longest(graph, item.then), _longest(graph, item.other))
    if isinstance(item, Operation | Pair):
        op = item.op if isinstance(item, Pair) else graph.nodes[item.node].op
        return WAITS.get(op, 4)
    return 0


def _longest(graph: Graph, items: Iterable[Item]) -> int:
    """Length of the longest way through a scope."""
    ready = dict[int, int]()
    for item in items:
        begun = max((ready.get(number, 0) for number in item.reads), default=0)
        ready.update(dict.fromkeys(item.defines, begun + _waits(graph, item)))
    return max(ready.values(), default=0)
