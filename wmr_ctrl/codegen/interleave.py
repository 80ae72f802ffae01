"""Operations that gain by company: exponentials, sine and cosine of one angle, packed stores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca

from wmr_ctrl.codegen.items import (
    ExpBatch,
    Item,
    Operation,
    PackedStore,
    SinCos,
    Slice,
    computed,
    replaced,
)
from wmr_ctrl.model.graph import Graph

FEWEST = 4
"""Exponentials that are worth an array."""


def batch_exponentials(graph: Graph, items: Sequence[Item]) -> list[Item]:
    """The items with exponentials of one rank, of which none needs another, as one item each.

    Rank: how many exponentials stand before one on the longest way from the inputs.
    """
    rank: dict[int, int] = {}
    groups: dict[int, list[int]] = {}
    for item in items:
        before = max((rank.get(number, 0) for number in item.reads), default=0)
        if isinstance(item, Operation) and graph.nodes[item.node].op == ca.OP_EXP:
            groups.setdefault(before, []).append(item.node)
            before += 1
        rank.update(dict.fromkeys(item.defines, before))
    batches: list[ExpBatch] = []
    for group in groups.values():
        if len(group) >= FEWEST:
            operands = tuple(graph.nodes[number].operands[0] for number in group)
            cost, name = sum(map(graph.cost, group)), f"e{len(batches) + 1}"
            reads = computed(graph, operands)
            batches.append(ExpBatch(tuple(group), reads, cost, name, operands))
    return replaced(items, batches)


def pair_sines(graph: Graph, items: Sequence[Item]) -> list[Item]:
    """The items with sine and cosine of one angle as one item."""
    by_angle: dict[int, dict[int, int]] = {ca.OP_SIN: {}, ca.OP_COS: {}}
    for item in items:
        if isinstance(item, Operation) and (op := graph.nodes[item.node].op) in by_angle:
            by_angle[op][graph.nodes[item.node].operands[0]] = item.node
    sines, cosines = by_angle.values()
    pairs = [
        SinCos((sine, cosines[angle]), computed(graph, (angle,)), graph.cost(sine), angle)
        for angle, sine in sines.items()
        if angle in cosines
    ]
    return replaced(items, pairs)


def pack_stores(items: Sequence[Item], places: Mapping[int, tuple[str, int]]) -> list[Item]:
    """The items with the single lines that fill four elements of an array as one item."""
    lines = {
        places[item.node]: item
        for item in items
        if isinstance(item, Operation) and item.node in places
    }
    packs = []
    for array, start in lines:
        four = [line for k in range(4) if (line := lines.get((array, start + k)))]
        if start % 4 == 0 and len(four) == 4:
            defines = tuple(line.node for line in four)
            reads = frozenset().union(*(line.reads for line in four))
            cost = sum(line.cost for line in four)
            packs.append(PackedStore(defines, reads, cost, Slice(array, start)))
    return replaced(items, packs) if packs else list(items)
