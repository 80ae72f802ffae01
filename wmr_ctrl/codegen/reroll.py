"""Loops over arrays for runs of similar operations, so that compilers vectorise them.

An SX graph has no arrays: 64 products are 64 statements.  Operations of one kind and one depth
whose operands are adjacent in a vector become one loop; their other operands are either equal for
all of them (the condition of a choice always is) or are placed side by side in a local array,
backwards through the graph.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import casadi as ca

from wmr_ctrl.world.model.graph import SELECT, Graph, Node

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
    computed,
    replaced,
)

SHORTEST = 8
"""Fewest elements that a loop is begun with."""
SHORTEST_PART = 4
"""Fewest elements of a loop that fills part of an array which a longer loop reads."""
SHORTEST_FUSED = 8
"""Loops shorter than this take no other loop into their expression: eight lanes stay eight."""

AMPLE = 1024
"""Numbers of local arrays up to which each has room of its own."""

_LOOPED = frozenset(
    {ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_DIV, ca.OP_NEG, ca.OP_SQ, ca.OP_TWICE, ca.OP_FMIN,
     ca.OP_FMAX, SELECT}
)  # fmt: skip

Place = tuple[str, int]
Operands = tuple[Slice | int, ...]
Sharing = tuple[object, ...]


def reroll(graph: Graph, items: Sequence[Item]) -> tuple[list[Item], dict[int, Place]]:
    """The items with loops for runs of lines, and the array element of every value in an array."""
    rolling = _Rerolling(graph, items)
    rolling.find()
    local = {k: place for k, place in rolling.place.items() if k not in rolling.given}
    results = [item for item in items if isinstance(item, ResultStore)]
    others = [item for item in items if not isinstance(item, ResultStore)]
    return replaced([*others, *_looped_results(results, local)], rolling.loops), local


class _Rerolling:
    def __init__(self, graph: Graph, items: Sequence[Item]) -> None:
        self.graph, self.loops = graph, list[ArrayLoop]()
        self.depth = depths(items)
        self.lines = {item.node for item in items if isinstance(item, Operation)}
        self.place = {k: node.place for k, node in enumerate(graph.nodes) if node.place}
        self.given = frozenset(self.place)
        self.arrays = 0

    def find(self) -> None:
        """Find and replace all runs, starting at the inputs."""
        by_depth: dict[int, list[int]] = {}
        for number in sorted(self.lines):
            if self._is_looped(number):
                by_depth.setdefault(self.depth[number], []).append(number)
        for depth in sorted(by_depth):
            made = -1
            while made != len(self.loops):  # what was laid out may let others of this depth follow
                made = len(self.loops)
                for run in self._runs(by_depth[depth]):
                    self._roll(run)

    def _is_looped(self, number: int) -> bool:
        return self.graph.nodes[number].op in _LOOPED and not self.graph.is_logical(number)

    def _runs(self, numbers: Iterable[int]) -> list[list[int]]:
        """Lines of one depth whose located operands are consecutive."""
        free = [number for number in numbers if number not in self.place]
        common = self._common(free)
        groups: dict[tuple[object, ...], list[tuple[int, int]]] = {}
        for number in free:
            key, start = self._key(number, common)
            if start is not None:
                groups.setdefault(key, []).append((start, number))
        return [run for group in groups.values() for run in self._split(sorted(group))]

    def _common(self, numbers: list[int]) -> set[Sharing]:
        """Operands that many of the lines share, each with the other operands' arrays."""
        count: Counter[Sharing] = Counter()
        for number in numbers:
            count.update(self._sharings(number))
        return {key for key, often in count.items() if often >= SHORTEST}

    def _sharings(self, number: int) -> list[Sharing]:
        """For each operand: operation, position, operand, and the other operands' arrays."""
        node = self.graph.nodes[number]
        arrays = [self.place.get(operand, ("",))[0] for operand in node.operands]
        return [
            (node.op, position, operand, *(arrays[:position] + arrays[position + 1 :]))
            for position, operand in enumerate(node.operands)
        ]

    def _key(self, number: int, common: set[Sharing]) -> tuple[tuple[object, ...], int | None]:
        """Key that the lines of a run have in common, and this line's position in the run."""
        node, start = self.graph.nodes[number], None
        parts: list[object] = [node.op]
        for position, sharing in enumerate(self._sharings(number)):
            operand = node.operands[position]
            place = self.place.get(operand)
            if sharing in common or _is_condition(node, position):
                parts.append(operand)
            elif place is None:
                parts.append(None)
            else:
                start = place[1] if start is None else start
                parts.append((place[0], place[1] - start))
        return tuple(parts), start

    def _split(self, group: list[tuple[int, int]]) -> list[list[int]]:
        """Longest runs of consecutive starts whose operands are each one value or all different."""
        runs: list[list[int]] = []
        last = None
        for start, number in group:
            if last is None or start != last + 1 or not self._fits(runs[-1], number):
                runs.append([])
            runs[-1].append(number)
            last = start
        return [run for run in runs if len(run) >= SHORTEST]

    def _fits(self, run: list[int], number: int) -> bool:
        nodes = [self.graph.nodes[k].operands for k in run]
        return all(
            _alike([operands[position] for operands in nodes], operand)
            for position, operand in enumerate(self.graph.nodes[number].operands)
        )

    def _roll(self, run: list[int]) -> None:
        """Turn the run into an array, unless an operand cannot be placed in one."""
        count, place, arrays = len(self.loops), dict(self.place), self.arrays
        if any(number in place for number in run):  # moved by another run meanwhile
            return
        if not self._laid_out(run, self._new_array(), 0):
            del self.loops[count:]
            self.place, self.arrays = place, arrays

    def _laid_out(self, run: Sequence[int], array: str, start: int) -> bool:
        operands = self._operands(run)
        if operands is None:
            return False
        numbers = [operand for k in run for operand in self.graph.nodes[k].operands]
        op, target = self.graph.nodes[run[0]].op, Slice(array, start)
        reads = computed(self.graph, numbers)
        self.loops.append(ArrayLoop(tuple(run), reads, len(run), target, len(run), op, operands))
        self.place.update((number, (array, start + j)) for j, number in enumerate(run))
        return True

    def _operands(self, run: Sequence[int]) -> Operands | None:
        nodes, found = [self.graph.nodes[number] for number in run], list[Slice | int]()
        for position in range(len(nodes[0].operands)):
            wanted = [node.operands[position] for node in nodes]
            place = wanted[0] if len(set(wanted)) == 1 else self._slice(wanted)
            if place is None or (isinstance(place, Slice) and _is_condition(nodes[0], position)):
                return None
            found.append(place)
        return tuple(found)

    def _slice(self, wanted: list[int]) -> Slice | None:
        """Slice of these values; they are placed in a new array if they are not in one yet."""
        places = [self.place.get(number) for number in wanted]
        first = places[0]
        if first is not None:
            array, start = first
            beside = all(place == (array, start + j) for j, place in enumerate(places))
            return Slice(array, start) if beside else None
        depths = {self.depth.get(number) for number in wanted}
        kinds = {self.graph.nodes[number].op for number in wanted}
        alone = not any(places) and set(wanted) <= self.lines and len(set(wanted)) == len(wanted)
        alike = len(depths) == 1 and len(kinds) == 1 and all(map(self._is_looped, wanted))
        return self._array_of(wanted) if alone and alike else None

    def _array_of(self, wanted: list[int]) -> Slice | None:
        """A new array of these values: as loops if they are long enough, else single lines."""
        array, start = self._new_array(), 0
        for part in self._segments(wanted):
            if len(part) >= SHORTEST_PART and not self._laid_out(part, array, start):
                return None
            self.place.update((number, (array, start + j)) for j, number in enumerate(part))
            start += len(part)
        return Slice(array, 0)

    def _segments(self, wanted: list[int]) -> list[list[int]]:
        parts: list[list[int]] = [[]]
        for number in wanted:
            if parts[-1] and not self._fits(parts[-1], number):
                parts.append([])
            parts[-1].append(number)
        return parts

    def _new_array(self) -> str:
        self.arrays += 1
        return f"a{self.arrays}"


def _is_condition(node: Node, position: int) -> bool:
    return node.op == SELECT and position == 0


def _alike(before: list[int], operand: int) -> bool:
    """True if ``operand`` continues a list of one repeated value or of distinct values."""
    if len(before) == 1:
        return True
    return operand == before[0] if before[0] == before[1] else operand not in before


def depths(items: Iterable[Item]) -> dict[int, int]:
    """Longest path from the scope's inputs to each value."""
    depth: dict[int, int] = {}
    for item in items:
        level = 1 + max((depth.get(number, 0) for number in item.reads), default=0)
        depth.update(dict.fromkeys(item.defines, level))
    return depth


def _looped_results(results: Iterable[ResultStore], local: dict[int, Place]) -> list[Item]:
    """Results with loops that copy parts of an array; other results unchanged."""
    runs: list[list[ResultStore]] = []
    following: tuple[Place, Place] | None = None  # place and result that would go on a run
    for item in results:
        store, place = item.store, local.get(item.store.node)
        if place is None or (place, (store.vector, store.index)) != following:
            runs.append([])
        runs[-1].append(item)
        following = place and ((place[0], place[1] + 1), (store.vector, store.index + 1))
    found: list[Item] = []
    for run in runs:
        if len(run) < SHORTEST_PART:
            found.extend(run)
            continue
        first, reads = run[0].store, frozenset().union(*(item.reads for item in run))
        target, source = Slice(first.vector, first.index), Slice(*local[first.node])
        found.append(ArrayLoop((), reads, 0, target, len(run), None, (source,)))
    return found


def fused(graph: Graph, items: Sequence[Item]) -> set[ArrayLoop]:
    """Loops to insert at their readers: each element is read once, by long loops over this part
    alone.

    A few elements may be read by single lines.  The loop's expression is inserted at the reader,
    with a shifted index.
    """
    reads = _reads(graph, items)
    loops = [item for item in items if isinstance(item, ArrayLoop)]
    own = (x for x in loops if x.defines and all(reads[number] == 1 for number in x.defines))
    return {loop for loop in own if _read_by_loops(loop, loops)}


def _reads(graph: Graph, items: Iterable[Item]) -> Counter[int]:
    count: Counter[int] = Counter()
    for item in items:
        if isinstance(item, ArrayLoop):
            for number in item.defines:
                count.update(graph.nodes[number].operands)
            count.update(item.reads if item.op is None else ())
        elif isinstance(item, Operation | PackedStore | SinCos):
            for number in item.defines:
                count.update(graph.nodes[number].operands)
        elif isinstance(item, ExpBatch):
            count.update(item.operands)
        elif isinstance(item, ResultStore):
            count[item.store.node] += 1
        elif isinstance(item, IfElse):
            count.update(dict.fromkeys(item.reads, 2))
    return count


def _read_by_loops(loop: ArrayLoop, users: Iterable[ArrayLoop]) -> bool:
    """True if long loops read most of its elements, each within its bounds."""
    covered = 0
    for user in users:
        for operand in user.operands:
            if not isinstance(operand, Slice) or operand.array != loop.target.array:
                continue
            start, end = operand.start, operand.start + user.length
            low, high = loop.target.start, loop.target.start + loop.length
            if end <= low or start >= high:
                continue
            if start < low or end > high or user.length < SHORTEST_FUSED:
                return False
            covered += user.length
    return 4 * covered >= 3 * loop.length


def shared_rooms(
    items: Sequence[Item], places: Mapping[int, Place], folded: Iterable[ArrayLoop]
) -> tuple[dict[str, str], dict[str, int]]:
    """C names of local arrays, and sizes by name; arrays that are no longer read share memory."""
    sizes, ends, inner = dict[str, int](), dict[str, int](), set(folded)
    reads = {number: item.reads for item in inner for number in item.defines}
    begins = dict[str, int]()
    for at, item in enumerate(items):
        if item in inner:
            continue
        wanted, seen = [*item.reads, *item.defines], set[int]()
        while wanted:
            number = wanted.pop()
            if number in seen:
                continue
            seen.add(number)
            if number in reads:
                wanted.extend(reads[number])
            elif number in places:
                array, index = places[number]
                sizes[array] = max(sizes.get(array, 0), index + 1)
                begins.setdefault(array, at)
                ends[array] = at
    if sum(sizes.values()) <= AMPLE:
        return {}, sizes
    rooms, taken = dict[str, str](), dict[str, tuple[int, int]]()
    for array in sorted(sizes, key=lambda name: (begins[name], -sizes[name])):
        free = [name for name, (_, end) in taken.items() if end < begins[array]]
        room = min(free, key=lambda name: abs(taken[name][0] - sizes[array]), default=array)
        size = max(sizes[array], taken.get(room, (0, 0))[0])
        rooms[array], taken[room] = room, (size, ends[array])
    return rooms, {name: size for name, (size, _) in taken.items()}
