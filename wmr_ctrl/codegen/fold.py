"""Which loops need no array of their own because one later loop reads each element once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from wmr_ctrl.codegen.items import (
    Four,
    IfElse,
    Item,
    Operation,
    Roll,
    Slice,
    Together,
    Turn,
    Writing,
)
from wmr_ctrl.model.graph import Graph

LONG_ENOUGH = 8
"""Loops shorter than this take no other loop into their expression: eight lanes stay eight."""


def folded(graph: Graph, items: Sequence[Item]) -> set[Roll]:
    """Loops whose elements are each read once, by a long loop that reads nothing else of the array.

    Their expressions are written where they are read, with the index shifted.
    """
    reads = _reads(graph, items)
    by_array: dict[str, list[Roll]] = {}
    for item in items:
        if isinstance(item, Roll) and item.defines:
            by_array.setdefault(item.target.array, []).append(item)
    users = [item for item in items if isinstance(item, Roll)]
    return {
        roll
        for rolls in by_array.values()
        for roll in rolls
        if all(reads[number] == 1 for number in roll.defines) and _read_by_loops(roll, users)
    }


def _reads(graph: Graph, items: Iterable[Item]) -> Counter[int]:
    """How often each value is read."""
    count: Counter[int] = Counter()
    for item in items:
        if isinstance(item, Roll):
            for number in item.defines:
                count.update(graph.nodes[number].operands)
            count.update(item.reads if item.op is None else ())
        elif isinstance(item, Operation | Four | Turn):
            for number in item.defines:
                count.update(graph.nodes[number].operands)
        elif isinstance(item, Together):
            count.update(item.operands)
        elif isinstance(item, Writing):
            count[item.store.node] += 1
        elif isinstance(item, IfElse):
            count.update(dict.fromkeys(item.reads, 2))
    return count


def _read_by_loops(roll: Roll, users: Iterable[Roll]) -> bool:
    """Whether long loops read all of it, each within its bounds."""
    covered = 0
    for user in users:
        for operand in user.operands:
            if not isinstance(operand, Slice) or operand.array != roll.target.array:
                continue
            start, end = operand.start, operand.start + user.length
            low, high = roll.target.start, roll.target.start + roll.length
            if end <= low or start >= high:
                continue
            if start < low or end > high or user.length < LONG_ENOUGH:
                return False
            covered += user.length
    return covered == roll.length
