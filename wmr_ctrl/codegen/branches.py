"""Choices between expensive values as real branches.

A graph evaluates both sides of every choice.  Here all choices on one condition are collected with
the operations that only one side needs; if those are worth a branch they move into
``if (...) { } else { }``, and the same is done inside.  No value changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from wmr_ctrl.codegen.items import IfElse, Item, Operation, ordered, values
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
        scope = _Scope(graph, items, outside)
        candidates = [_Branch(graph, scope, condition, worth) for condition in scope.choices]
        best = max(candidates, key=lambda item: item.cost, default=None)
        if best is None or best.cost < worth:
            return items
        items = ordered(best.contracted())


class _Scope:
    """Items in order, who makes and who reads each value, the choices on each condition.

    ``outside`` are the values that are read outside of it.
    """

    def __init__(self, graph: Graph, items: list[Item], outside: frozenset[int]) -> None:
        self.items, self.outside = items, outside
        self.position = {item: place for place, item in enumerate(items)}
        self.maker = {number: item for item in items for number in item.defines}
        self.users: dict[int, list[Item]] = {}
        for item in items:
            for number in item.reads:
                self.users.setdefault(number, []).append(item)
        self.choices = _choices(graph, items)

    def dependents(self, start: Item, last: int) -> Iterator[Item]:
        """What needs an item, as far as position ``last``."""
        waiting, known = [start], {start}
        while waiting:
            item = waiting.pop()
            for number in item.defines:
                for user in self.users.get(number, ()):
                    if user not in known and self.position[user] <= last:
                        known.add(user)
                        waiting.append(user)
                        yield user


def _choices(graph: Graph, items: Iterable[Item]) -> dict[int, list[Operation]]:
    """The choices that stand as lines, in order, by their conditions."""
    found: dict[int, list[Operation]] = {}
    for item in items:
        if isinstance(item, Operation) and graph.nodes[item.node].op == SELECT:
            condition = graph.nodes[item.node].operands[0]
            if not graph.nodes[condition].leaf:
                found.setdefault(condition, []).append(item)
    return found


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

    def _block(self) -> IfElse:
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
        return IfElse(defines, reads, cost, self.condition, tuple(inner[0]), tuple(inner[1]))

    def _arms(self, side: int) -> list[int]:
        return [self.graph.nodes[item.node].operands[side] for item in self.choices]

    def _independent_choices(self) -> list[Operation]:
        """Choices on the condition none of which depends on another."""
        listed = self.scope.choices[self.condition]
        last = self.scope.position[listed[-1]]
        chosen: list[Operation] = []
        dependent: set[Item] = set()
        for item in listed:
            if item not in dependent:
                chosen.append(item)
                dependent.update(
                    self.scope.dependents(item, last) if item is not listed[-1] else ()
                )
        return chosen

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

    def _only(self, number: int, side: int, inside: set[Item], choices: set[Operation]) -> bool:
        return number not in self.scope.outside and all(
            user in inside or (user in choices and self._on_side(user, number, side))
            for user in self.scope.users.get(number, ())
        )

    def _on_side(self, choice: Item, number: int, side: int) -> bool:
        operands = self.graph.nodes[choice.defines[0]].operands
        return all((operand == number) <= (place == side) for place, operand in enumerate(operands))


def _cost(items: Iterable[Item]) -> int:
    return sum(item.cost for item in items)
