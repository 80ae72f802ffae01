"""Choices between expensive values as real branches.

A graph evaluates both sides of every choice.  Here all choices on one condition are collected with
the operations that only one side needs; if those are worth a branch they move into
``if (...) { } else { }``, and the same is done inside.  No value changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from wmr_ctrl.codegen.items import Block, Item, Line, ordered, values
from wmr_ctrl.model.graph import SELECT, Graph

WORTH = 15
"""Cost (see `Graph.cost`) of what a branch saves, from which on it is made."""


def branched(
    graph: Graph, items: Sequence[Item], needed: Iterable[int] = (), *, worth: int = WORTH
) -> list[Item]:
    """The items of one scope with branches where they pay; ``needed`` is read outside of it.

    With ``worth`` 1 nothing is computed that is not asked for.
    """
    outside, items = frozenset(needed), list(items)
    while True:
        scope = _Scope(items, outside)
        candidates = [_Branch(graph, scope, c, worth) for c in _conditions(graph, items)]
        best = max(candidates, key=lambda item: item.cost, default=None)
        if best is None or best.cost < worth:
            return items
        items = ordered(best.contracted())


class _Scope:
    """Items in order, who makes and who reads each value, and what is read outside."""

    def __init__(self, items: list[Item], outside: frozenset[int]) -> None:
        self.items, self.outside = items, outside
        self.position = {item: place for place, item in enumerate(items)}
        self.maker = {number: item for item in items for number in item.defines}
        self.users: dict[int, list[Item]] = {}
        for item in items:
            for number in item.reads:
                self.users.setdefault(number, []).append(item)


def _conditions(graph: Graph, items: Sequence[Item]) -> list[int]:
    """Conditions of the choices that stand as lines, in order."""
    found = {
        graph.nodes[item.node].operands[0]: None
        for item in items
        if isinstance(item, Line) and graph.nodes[item.node].op == SELECT
    }
    return [number for number in found if not graph.nodes[number].leaf]


class _Branch:
    """The choices of one scope on one condition, and what only one side of them needs."""

    def __init__(self, graph: Graph, scope: _Scope, condition: int, worth: int) -> None:
        self.graph, self.scope, self.condition, self.worth = graph, scope, condition, worth
        self.choices = self._independent_choices()
        self.then, self.other = self._cone(1), self._cone(2)
        self.cost = max(_cost(self.then), _cost(self.other))

    def contracted(self) -> list[Item]:
        """The scope with choices and cones replaced by one block."""
        gone = {*self.choices, *self.then, *self.other}
        return [*(item for item in self.scope.items if item not in gone), self._block()]

    def _block(self) -> Block:
        defines = tuple(item.node for item in self.choices)
        arms = [values(self.graph, self._arms(side)) for side in (1, 2)]
        inner = [
            branched(self.graph, cone, arm, worth=self.worth)
            for cone, arm in zip((self.then, self.other), arms, strict=True)
        ]
        parts = [*self.then, *self.other]
        made = {number for item in parts for number in item.defines}
        reads = frozenset({self.condition}).union(*arms, *(item.reads for item in parts)) - made
        cost = _cost(parts) + len(defines)
        return Block(defines, reads, cost, self.condition, tuple(inner[0]), tuple(inner[1]))

    def _arms(self, side: int) -> list[int]:
        return [self.graph.nodes[item.node].operands[side] for item in self.choices]

    def _independent_choices(self) -> list[Line]:
        """Choices on the condition none of which depends on another."""
        lines = (item for item in self.scope.items if isinstance(item, Line))
        listed = [item for item in lines if self._is_choice(item)]
        if len(listed) == 1:
            return listed
        chosen: list[Line] = []
        tainted: set[int] = set()
        for item in self.scope.items:
            if not item.reads.isdisjoint(tainted):
                tainted.update(item.defines)
            elif isinstance(item, Line) and self._is_choice(item):
                chosen.append(item)
                tainted.update(item.defines)
        return chosen

    def _is_choice(self, item: Line) -> bool:
        node = self.graph.nodes[item.node]
        return node.op == SELECT and node.operands[0] == self.condition

    def _cone(self, side: int) -> list[Item]:
        """Items that nothing needs but this side of the choices, in order."""
        inside: set[Item] = set()
        choices = set(self.choices)
        waiting = self._arms(side)
        while waiting:
            item = self.scope.maker.get(waiting.pop())
            if item is None or item in inside or item in choices:
                continue
            if all(self._only(number, side, inside, choices) for number in item.defines):
                inside.add(item)
                waiting.extend(item.reads)
        return sorted(inside, key=self.scope.position.__getitem__)

    def _only(self, number: int, side: int, inside: set[Item], choices: set[Line]) -> bool:
        return number not in self.scope.outside and all(
            user in inside or (user in choices and self._on_side(user, number, side))
            for user in self.scope.users.get(number, ())
        )

    def _on_side(self, choice: Item, number: int, side: int) -> bool:
        operands = self.graph.nodes[choice.defines[0]].operands
        return all((operand == number) <= (place == side) for place, operand in enumerate(operands))


def _cost(items: Iterable[Item]) -> int:
    return sum(item.cost for item in items)
