"""Functions that gain by company: independent exponentials, and sine and cosine of one angle."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from wmr_ctrl.codegen.items import Item, Operation, Together, Turn, ordered, values
from wmr_ctrl.model.graph import Graph

FEWEST = 4
"""Exponentials that are worth an array."""


def interleave(graph: Graph, items: Sequence[Item]) -> list[Item]:
    """The items with exponentials of one rank, of which none needs another, as one item each."""
    groups = [group for group in _ranks(graph, items).values() if len(group) >= FEWEST]
    gone = {number for group in groups for number in group}
    kept = [item for item in items if not (isinstance(item, Operation) and item.node in gone)]
    made = [_together(graph, group, f"e{place}") for place, group in enumerate(groups, 1)]
    return ordered([*made, *kept])


def turns(graph: Graph, items: Sequence[Item]) -> list[Item]:
    """The items with sine and cosine of one angle as one item."""
    lines = [item for item in items if isinstance(item, Operation)]
    sines, cosines = (_of_angles(graph, lines, op) for op in (ca.OP_SIN, ca.OP_COS))
    made = [
        Turn((sine, cosines[angle]), values(graph, (angle,)), graph.cost(sine), angle)
        for angle, sine in sines.items()
        if angle in cosines
    ]
    gone = {number for item in made for number in item.defines}
    kept = [item for item in items if not (isinstance(item, Operation) and item.node in gone)]
    return ordered([*made, *kept])


def _of_angles(graph: Graph, lines: Sequence[Operation], op: int) -> dict[int, int]:
    """Of each angle its sine, or cosine."""
    found = [item.node for item in lines if graph.nodes[item.node].op == op]
    return {graph.nodes[number].operands[0]: number for number in found}


def _ranks(graph: Graph, items: Sequence[Item]) -> dict[int, list[int]]:
    """Exponentials by how many stand before them on the longest way from the inputs."""
    rank: dict[int, int] = {}
    groups: dict[int, list[int]] = {}
    for item in items:
        before = max((rank.get(number, 0) for number in item.reads), default=0)
        if isinstance(item, Operation) and graph.nodes[item.node].op == ca.OP_EXP:
            groups.setdefault(before, []).append(item.node)
            before += 1
        rank.update(dict.fromkeys(item.defines, before))
    return groups


def _together(graph: Graph, numbers: Sequence[int], array: str) -> Together:
    operands = tuple(graph.nodes[number].operands[0] for number in numbers)
    cost = sum(graph.cost(number) for number in numbers)
    return Together(tuple(numbers), values(graph, operands), cost, array, operands)
