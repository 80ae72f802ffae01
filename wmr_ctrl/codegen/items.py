"""Statements of a C function: single lines, branches, loops; and how they are scheduled.

A graph evaluates both sides of every choice.  Here all choices on one condition are collected with
the operations that only one side needs; if those are worth a branch they move into
``if (...) { } else { }``, and the same is done inside.  No value changes.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from wmr_ctrl.world.model.graph import SELECT, Graph, Store


@dataclass(frozen=True, eq=False)
class Item:
    """A statement: the values that it defines and those that it reads (except constants and
    inputs).
    """

    defines: tuple[int, ...]
    reads: frozenset[int]
    cost: int = 0


@dataclass(frozen=True, eq=False)
class Operation(Item):
    """One operation."""

    @property
    def node(self) -> int:
        """The value."""
        return self.defines[0]


@dataclass(frozen=True, eq=False)
class ResultStore(Item):
    """Store of one result."""

    store: Store = field(default=Store("", 0, 0))


@dataclass(frozen=True, eq=False)
class IfElse(Item):
    """``if (condition) then else other``; it defines the choices that share the condition."""

    condition: int = 0
    then: tuple[Item, ...] = ()
    other: tuple[Item, ...] = ()


@dataclass(frozen=True)
class Slice:
    """Elements ``array[start + j]`` of an array or vector."""

    array: str
    start: int


@dataclass(frozen=True, eq=False)
class ArrayLoop(Item):
    """``array[start + j] = op(...)`` for all j; an operand is a Slice, or one value for all j.

    ``op`` None copies.
    """

    target: Slice = field(default=Slice("", 0))
    length: int = 0
    op: int | None = None
    operands: tuple[Slice | int, ...] = ()


@dataclass(frozen=True, eq=False)
class PackedStore(Item):
    """Four operations as ``array[start]`` to ``array[start + 3]``."""

    target: Slice = field(default=Slice("", 0))


@dataclass(frozen=True, eq=False)
class SinCos(Item):
    """Sine and cosine, in this order, of one angle."""

    angle: int = 0


@dataclass(frozen=True, eq=False)
class ExpBatch(Item):
    """The exponentials of ``operands``, in order, as elements of an array."""

    array: str = ""
    operands: tuple[int, ...] = ()


def statements(graph: Graph) -> list[Item]:
    """Scheduled statements for all operations and results of a graph."""
    nodes = enumerate(graph.nodes)
    lines = [
        Operation((k,), computed(graph, node.operands), graph.cost(k))
        for k, node in nodes
        if not node.leaf
    ]
    stores = (ResultStore((), computed(graph, (s.node,)), 1, s) for s in graph.stores)
    return scheduled([*lines, *stores])


def computed(graph: Graph, numbers: Iterable[int]) -> frozenset[int]:
    """Those among ``numbers`` that a statement must compute first."""
    return frozenset(number for number in numbers if not graph.nodes[number].leaf)


def scheduled(items: Sequence[Item]) -> list[Item]:
    """Reorder items so that each is as late as possible, just before its first reader.

    The last items keep their order, so that results stay in place.
    """
    maker = {number: item for item in items for number in item.defines}
    done, begun = dict[Item, None](), set[Item]()
    for start in (*(item for item in items if not item.defines), *items):
        stack = [start]  # depth first, without recursion: chains are hundreds long
        while stack:
            item = stack[-1]
            if item in begun:
                done[stack.pop()] = None
                continue
            begun.add(item)
            reads = item.reads
            for number in sorted(reads, reverse=True) if len(reads) > 1 else reads:
                before = maker.get(number)
                if before is not None and before not in done:
                    stack.append(before)
    return list(done)


def replaced(items: Iterable[Item], new: Sequence[Item]) -> list[Item]:
    """The scheduled items, with ``new`` ones in place of the lines that compute the same values."""
    gone = {number for item in new for number in item.defines}
    rest = (item for item in items if not (isinstance(item, Operation) and item.node in gone))
    return scheduled([*new, *rest])


WORTH = 15
"""Cost (see `Graph.cost`) of what a branch saves, from which on it is made."""


def branched(
    graph: Graph, items: Sequence[Item], needed: Iterable[int] = (), *, worth: int = WORTH
) -> list[Item]:
    """The items of one scope, with branches where they pay; ``needed`` is read outside of it.

    With ``worth`` 1 nothing is computed unless it is needed.
    """
    outside, items = frozenset(needed), list(items)
    while _cost(items) >= worth:
        scope = _Scope(graph, items, outside)
        branches = (_Branch(graph, scope, condition, worth) for condition in scope.choices)
        best = max(branches, key=lambda one: one.cost, default=None)
        if best is None or best.cost < worth:
            break
        items = scheduled(best.contracted())
    return items


class _Scope:
    """Items in order, the maker of each value, its number of readers, the choices by condition.

    ``kept``: items whose value is read outside.  ``uses``: number of readers of an item, each
    counted once per value that it reads.  ``choices``: single lines.
    """

    def __init__(self, graph: Graph, items: list[Item], outside: frozenset[int]) -> None:
        self.graph, self.items = graph, items
        self.position = {item: place for place, item in enumerate(items)}
        self.maker = {number: item for item in items for number in item.defines}
        self.kept = {item for number, item in self.maker.items() if number in outside}
        self.uses = Counter(
            self.maker[number] for item in items for number in item.reads if number in self.maker
        )
        self.choices: dict[int, list[Operation]] = {}
        for item in items:
            if isinstance(item, Operation) and graph.nodes[item.node].op == SELECT:
                condition = graph.nodes[item.node].operands[0]
                if not graph.nodes[condition].leaf:
                    self.choices.setdefault(condition, []).append(item)


class _Branch:
    """The choices of one scope on one condition, with the operations that only one side needs."""

    def __init__(self, graph: Graph, scope: _Scope, condition: int, worth: int) -> None:
        self.graph, self.scope, self.condition, self.worth = graph, scope, condition, worth
        self.choices = self._independent_choices()
        self.needs = [self._needs(item) for item in self.choices]
        self.then, self.other = self._cone(1), self._cone(2)
        self.cost = max(_cost(self.then), _cost(self.other))

    def contracted(self) -> list[Item]:
        """The scope with these choices and operations replaced by one block."""
        defines = tuple(number for item in self.choices for number in item.defines)
        arms = [frozenset().union(*(both[side] for both in self.needs)) for side in (0, 1)]
        then, other = (
            tuple(branched(self.graph, cone, arm, worth=self.worth))
            for cone, arm in zip((self.then, self.other), arms, strict=True)
        )
        parts = [*self.then, *self.other]
        made = {number for item in parts for number in item.defines}
        reads = frozenset({self.condition}).union(*arms, *(item.reads for item in parts)) - made
        cost = _cost(parts) + len(defines)
        block = IfElse(defines, reads, cost, self.condition, then, other)
        gone = {*self.choices, *parts}
        return [*(item for item in self.scope.items if item not in gone), block]

    def _needs(self, item: Operation) -> tuple[frozenset[int], frozenset[int]]:
        """Values that each side of a choice needs computed first."""
        _, *arms = self.graph.nodes[item.node].operands
        yes, no = (computed(self.graph, [arm]) for arm in arms)
        return yes, no

    def _independent_choices(self) -> list[Operation]:
        """Choices on the condition that do not depend on each other."""
        listed, position = self.scope.choices[self.condition], self.scope.position
        if len(listed) == 1:
            return listed
        first, last = position[listed[0]], position[listed[-1]]
        own: set[Item] = set(listed)
        dependent: set[Item] = set()
        made: set[int] = set()  # by choices, and by what depends on them
        for item in self.scope.items[first : last + 1]:
            if not made.isdisjoint(item.reads):
                dependent.add(item)
            if item in own or item in dependent:
                made.update(item.defines)
        return [item for item in listed if item not in dependent]

    def _cone(self, side: int) -> list[Item]:
        """Items that only this side of the choices needs, in order.

        The search starts with the values that choices read on this side only, once for each choice.
        An item is included with the last of its readers.
        """
        scope, left = self.scope, dict[Item, int]()
        inside: list[Item] = []
        choices, kept, maker, uses = set(self.choices), scope.kept, scope.maker, scope.uses
        own = (both[side - 1] - both[2 - side] - {self.condition} for both in self.needs)
        waiting = [number for numbers in own for number in sorted(numbers)]
        while waiting:
            item = maker.get(waiting.pop())
            if item is None or item in choices or item in kept:
                continue
            left[item] = still = left.get(item, uses[item]) - 1
            if still == 0:
                inside.append(item)
                waiting.extend(item.reads)
        return sorted(inside, key=scope.position.__getitem__)


def _cost(items: Iterable[Item]) -> int:
    return sum(item.cost for item in items)
