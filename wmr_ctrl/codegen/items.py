"""Statements of a C function: single lines, branches, loops; and how they are scheduled."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from wmr_ctrl.model.graph import Graph, Store


@dataclass(frozen=True, eq=False)
class Item:
    """A statement: the values it defines and those (no constants, no inputs) it reads."""

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
    """One result stored."""

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
    """A statement for each operation and each result of a graph, scheduled."""
    nodes = enumerate(graph.nodes)
    lines = [
        Operation((k,), computed(graph, node.operands), graph.cost(k))
        for k, node in nodes
        if not node.leaf
    ]
    stores = (ResultStore((), computed(graph, (s.node,)), 1, s) for s in graph.stores)
    return scheduled([*lines, *stores])


def computed(graph: Graph, numbers: Iterable[int]) -> frozenset[int]:
    """Those of ``numbers`` that a statement must have computed before."""
    return frozenset(number for number in numbers if not graph.nodes[number].leaf)


def scheduled(items: Sequence[Item]) -> list[Item]:
    """The items with each one as late as its first reader allows, but never after a reader.

    The last items keep their order, so that results stay where they are.
    """
    maker = {number: item for item in items for number in item.defines}
    done: dict[Item, None] = {}
    for start in (*(item for item in items if not item.defines), *items):
        stack = [(start, False)]  # depth first, without recursion: chains are hundreds long
        while stack:
            item, ready = stack.pop()
            if item in done:
                continue
            if ready:
                done[item] = None
                continue
            stack.append((item, True))
            before = [maker[k] for k in sorted(item.reads, reverse=True) if k in maker]
            stack.extend((other, False) for other in before if other not in done)
    return list(done)


def replaced(items: Iterable[Item], new: Sequence[Item]) -> list[Item]:
    """The items, scheduled, with ``new`` ones in the place of lines that they compute."""
    gone = {number for item in new for number in item.defines}
    rest = (item for item in items if not (isinstance(item, Operation) and item.node in gone))
    return scheduled([*new, *rest])
