"""What a C function body consists of: single lines, branches, loops; and how they are ordered."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from wmr_ctrl.model.graph import Graph, Store


@dataclass(frozen=True, eq=False)
class Item:
    """A piece of the body: the values it defines and those (no constants, no inputs) it reads."""

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
class Writing(Item):
    """One result written."""

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
class Roll(Item):
    """``array[start + j] = op(...)`` for all j; an operand is a Slice, or one value for all j.

    ``op`` None copies.
    """

    target: Slice = field(default=Slice("", 0))
    length: int = 0
    op: int | None = None
    operands: tuple[Slice | int, ...] = ()


@dataclass(frozen=True, eq=False)
class Four(Item):
    """Four operations as ``array[start]`` to ``array[start + 3]``."""

    target: Slice = field(default=Slice("", 0))


@dataclass(frozen=True, eq=False)
class Turn(Item):
    """Sine and cosine, in this order, of one angle."""

    angle: int = 0


@dataclass(frozen=True, eq=False)
class Together(Item):
    """The exponentials of ``operands``, in order, as elements of an array."""

    array: str = ""
    operands: tuple[int, ...] = ()


def operation(graph: Graph, number: int) -> Operation:
    """The item of one operation."""
    return Operation((number,), values(graph, graph.nodes[number].operands), graph.cost(number))


def writing(graph: Graph, store: Store) -> Writing:
    """The item of one result."""
    return Writing((), values(graph, (store.node,)), 1, store)


def values(graph: Graph, numbers: Iterable[int]) -> frozenset[int]:
    """Those of ``numbers`` that a statement must have computed before."""
    return frozenset(number for number in numbers if not graph.nodes[number].leaf)


def ordered(items: Sequence[Item]) -> list[Item]:
    """The items with each one as late as its first reader allows, but never after a reader.

    The last items keep their order, so that results stay where they are.
    """
    maker = {number: item for item in items for number in item.defines}
    found: dict[Item, None] = {}
    for item in (*(item for item in items if not item.defines), *items):
        _visit(item, maker, found)
    return list(found)


def _visit(start: Item, maker: dict[int, Item], found: dict[Item, None]) -> None:
    """Depth first, without recursion: chains are hundreds of operations long."""
    stack: list[tuple[Item, bool]] = [(start, False)]
    while stack:
        item, ready = stack.pop()
        if item in found:
            continue
        if ready:
            found[item] = None
            continue
        stack.append((item, True))
        before = [maker[number] for number in sorted(item.reads, reverse=True) if number in maker]
        stack.extend((other, False) for other in before if other not in found)
