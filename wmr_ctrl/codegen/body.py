"""One function's items as lines of C; exponentials, sines and stores are grouped first."""

from collections.abc import Iterable, Mapping, Sequence

import casadi as ca

from wmr_ctrl.world.model.graph import SELECT, Graph

from .dialect import TRUTHS, Dialect
from .items import (
    ArrayLoop,
    ExpBatch,
    IfElse,
    Item,
    Operation,
    PackedStore,
    ResultStore,
    SinCos,
    Slice,
    branched,
    computed,
    replaced,
    statements,
)
from .reroll import Place, fused, reroll, shared_rooms

_STEP = "    "
MOST_BRANCHED = 4_000
"""Choices up to which branches are looked for.

A path of hundreds of points has more: to look would take minutes and nest too deeply.
"""
FEWEST = 4
"""Exponentials that are worth an array."""


def body(graph: Graph, dialect: Dialect) -> list[str]:
    """Statements of a function that computes the graph: branches, loops, and results last."""
    items: list[Item] = [*statements(graph)]
    if dialect.plain:
        return _Writer(graph, dialect, items, {}).text()
    if sum(node.op == SELECT for node in graph.nodes) <= MOST_BRANCHED:
        items = branched(graph, items)
    if dialect.exp_batch:
        items = batch_exponentials(graph, items)
    if dialect.pairs_sines:
        items = pair_sines(graph, items)
    items, places = reroll(graph, items)
    if dialect.packs_stores:
        items = pack_stores(items, places)
    return _Writer(graph, dialect, items, places).text()


def batch_exponentials(graph: Graph, items: Sequence[Item]) -> list[Item]:
    """Merge independent exponentials of one rank into one item each.

    Rank: number of exponentials before one on the longest path from the inputs.
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
    """Merge the sine and cosine of one angle into one item."""
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
    """Merge single lines that fill four elements of an array into one item."""
    placed = (item for item in items if isinstance(item, Operation) and item.node in places)
    lines = {places[item.node]: item for item in placed}
    packs = []
    for array, start in lines:
        four = [line for k in range(4) if (line := lines.get((array, start + k)))]
        if start % 4 == 0 and len(four) == 4:
            defines = tuple(line.node for line in four)
            reads = frozenset().union(*(line.reads for line in four))
            cost = sum(line.cost for line in four)
            packs.append(PackedStore(defines, reads, cost, Slice(array, start)))
    return replaced(items, packs) if packs else list(items)


class _Writer:
    def __init__(
        self,
        graph: Graph,
        dialect: Dialect,
        items: Sequence[Item],
        places: Mapping[int, Place],
    ) -> None:
        self.graph, self.dialect, self.items, self.places = graph, dialect, items, places
        batches = (item for item in items if isinstance(item, ExpBatch))
        self.grouped = {k: (item.array, i) for item in batches for i, k in enumerate(item.defines)}
        self.fused = fused(graph, items)
        self.loops = [item for item in items if isinstance(item, ArrayLoop) and item.defines]
        self.rooms, self.sizes = shared_rooms(items, places, self.fused)

    def text(self) -> list[str]:
        """All lines, with the local arrays first."""
        real = self.dialect.real
        arrays = [f"{_STEP}{real} {name}[{size}];" for name, size in self.sizes.items()]
        return [*arrays, *self._lines(self.items, _STEP)]

    def _lines(self, items: Iterable[Item], indent: str) -> list[str]:
        found: list[str] = []
        for item in items:
            if isinstance(item, Operation):
                k = item.node
                declared = "" if k in self.places else f"const {self._type(k)} "
                found.append(f"{indent}{declared}{self._name(k)} = {self._expression(k)};")
            elif isinstance(item, ResultStore):
                target = f"{item.store.vector}[{item.store.index}]"
                found.append(f"{indent}{target} = {self._real(item.store.node)};")
            elif isinstance(item, IfElse):
                write = self._lane_block if self.dialect.lanes else self._branch
                found.extend(write(item, indent))
            elif isinstance(item, PackedStore):
                four = self._four(item.target, map(self._expression, item.defines))
                found.append(indent + four)
            elif isinstance(item, SinCos):
                sine, cosine = map(self._name, item.defines)
                found.append(f"{indent}{self.dialect.real} {sine}, {cosine};")
                called = f"wmr_sin_cos({self._real(item.angle)}, &{sine}, &{cosine});"
                found.append(f"{indent}{called}")
            elif isinstance(item, ExpBatch):
                found.extend(self._exponentials(item, indent))
            elif isinstance(item, ArrayLoop) and item not in self.fused:
                found.extend(self._loop(item, indent))
        return found

    def _exponentials(self, item: ExpBatch, indent: str) -> list[str]:
        """Batched exp, zero-padded to a multiple of the dialect's size."""
        given = [self._real(number) for number in item.operands]
        given += [self.dialect.number(0.0)] * (-len(given) % self.dialect.exp_batch)
        name, size = f"{self.dialect.real} {item.array}", len(given)
        called = f"{indent}wmr_exp_many({item.array}, {size});"
        if not self.dialect.packs_stores:
            return [f"{indent}{name}[{size}] = {{{', '.join(given)}}};", called]
        fours = [
            indent + self._four(Slice(item.array, k), given[k : k + 4]) for k in range(0, size, 4)
        ]
        return [f"{indent}{name}[{size}];", *fours, called]

    def _four(self, target: Slice, given: Iterable[str]) -> str:
        array = self._room(target.array)
        at = f"{array} + {target.start}" if target.start else array
        return f"wmr_four({at}, {', '.join(given)});"

    def _expression(self, number: int) -> str:
        node = self.graph.nodes[number]
        if node.op == SELECT:
            truths = self.graph.is_logical(number)
            arm = self._truth if truths else self._real
            condition, yes, no = node.operands
            return self.dialect.choice(self._truth(condition), arm(yes), arm(no), truths=truths)
        given = self._truth if node.op in TRUTHS else self._real
        return self.dialect.pattern(node.op).format(*(given(k) for k in node.operands))

    def _type(self, number: int) -> str:
        return self.dialect.truth if self.graph.is_logical(number) else self.dialect.real

    def _name(self, number: int) -> str:
        node = self.graph.nodes[number]
        place = node.place or self.places.get(number) or self.grouped.get(number)
        if place is not None:
            inner = None if node.place else self._folded_at(*place)
            if inner is not None:
                return f"({self._looped(inner, place[1] - inner.target.start, '')})"
            return f"{self._room(place[0])}[{place[1]}]"
        return self.dialect.number(node.number) if node.leaf else f"t{number}"

    def _room(self, array: str) -> str:
        """C name of an array; several that are not needed at the same time share one."""
        return self.rooms.get(array, array)

    def _real(self, number: int) -> str:
        name = self._name(number)
        return self.dialect.as_real(name) if self.graph.is_logical(number) else name

    def _truth(self, number: int) -> str:
        name = self._name(number)
        return name if self.graph.is_logical(number) else self.dialect.as_truth(name)

    def _loop(self, loop: ArrayLoop, indent: str) -> list[str]:
        target = f"{self._room(loop.target.array)}[{_shifted(loop.target.start)}]"
        head = f"{indent}for (int j = 0; j < {loop.length}; ++j) {{"
        return [head, f"{indent}{_STEP}{target} = {self._looped(loop, 0)};", f"{indent}}}"]

    def _looped(self, loop: ArrayLoop, shift: int, j: str = "j") -> str:
        """Element ``shift + j`` of a loop's result; without ``j`` that of a single line."""
        if loop.op == SELECT:
            condition, *arms = loop.operands
            assert isinstance(condition, int)  # the same for all elements
            yes, no = (self._element(operand, shift, j) for operand in arms)
            return self.dialect.choice(self._truth(condition), yes, no)
        shown = [self._element(operand, shift, j) for operand in loop.operands]
        return shown[0] if loop.op is None else self.dialect.pattern(loop.op).format(*shown)

    def _element(self, operand: Slice | int, shift: int, j: str) -> str:
        if isinstance(operand, int):
            return self._real(operand)
        inner = self._folded_at(operand.array, operand.start + shift)
        if inner is not None:
            return f"({self._looped(inner, operand.start + shift - inner.target.start, j)})"
        return f"{self._room(operand.array)}[{_shifted(operand.start + shift, j)}]"

    def _folded_at(self, array: str, index: int) -> ArrayLoop | None:
        for loop in self.loops:
            start = loop.target.start
            if loop.target.array == array and start <= index < start + loop.length:
                return loop if loop in self.fused else None
        return None

    def _branch(self, block: IfElse, indent: str) -> list[str]:
        found = [f"{indent}{self._type(k)} {self._name(k)};" for k in block.defines]
        inner = indent + _STEP
        found.append(f"{indent}if ({self._truth(block.condition)}) {{")
        found += self._arm(block.then, block.defines, 1, inner)
        found.append(f"{indent}}} else {{")
        found += self._arm(block.other, block.defines, 2, inner)
        return [*found, f"{indent}}}"]

    def _arm(
        self, items: Iterable[Item], choices: Iterable[int], side: int, indent: str
    ) -> list[str]:
        return [*self._lines(items, indent), *(
            f"{indent}{self._name(k)} = {self._chosen(k, side)};" for k in choices
        )]  # fmt: skip

    def _chosen(self, choice: int, side: int) -> str:
        operand = self.graph.nodes[choice].operands[side]
        return self._truth(operand) if self.graph.is_logical(choice) else self._real(operand)

    def _lane_block(self, block: IfElse, indent: str) -> list[str]:
        """Both sides, each computed if any lane needs it; the second is selected per lane."""
        condition, inner = self._truth(block.condition), indent + _STEP
        zero, found = self.dialect.number(0.0), list[str]()
        for k in block.defines:
            nothing = self.dialect.as_truth(zero) if self.graph.is_logical(k) else zero
            found.append(f"{indent}{self._type(k)} {self._name(k)} = {nothing};")
        found.append(f"{indent}if (wmr_some({condition})) {{")
        found += self._arm(block.then, block.defines, 1, inner)
        found.append(f"{indent}}}")
        found.append(f"{indent}if (wmr_some(wmr_not({condition}))) {{")
        found += self._lines(block.other, inner)
        for k in block.defines:
            truths = self.graph.is_logical(k)
            given = (condition, self._name(k), self._chosen(k, 2))
            chosen = self.dialect.choice(*given, truths=truths)
            found.append(f"{inner}{self._name(k)} = {chosen};")
        return [*found, f"{indent}}}"]


def _shifted(start: int, j: str = "j") -> str:
    return f"{j} + {start}" if j and start else j or f"{start}"
