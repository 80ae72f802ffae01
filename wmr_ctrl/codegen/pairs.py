"""Like operations on two values that lie side by side as one operation on a pair.

What a filter computes of its channels is the same for each, forwards and backwards.  From results
that lie side by side this walks backwards through the graph: two values of one operation become a
pair (`wmr_two` of arithmetic.h), which a processor with vectors computes at once, and so do their
operands, as far as they are alike; two that are not are computed one by one and joined.  Forwards
from these pairs, like operations on both halves of one become pairs, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import casadi as ca

from wmr_ctrl.codegen.items import Item, Operation, Pair, ResultStore, Two, computed, replaced
from wmr_ctrl.codegen.reroll import depths
from wmr_ctrl.model.graph import SELECT, Graph, Node

PAIRED = {
    ca.OP_ADD: "wmr_two_add({0}, {1})",
    ca.OP_SUB: "wmr_two_sub({0}, {1})",
    ca.OP_MUL: "wmr_two_mul({0}, {1})",
    ca.OP_DIV: "wmr_two_div({0}, {1})",
    ca.OP_FMIN: "wmr_two_min({0}, {1})",
    ca.OP_FMAX: "wmr_two_max({0}, {1})",
    ca.OP_NEG: "wmr_two_neg({0})",
    ca.OP_FABS: "wmr_two_abs({0})",
    ca.OP_EXPM1: "wmr_two_expm1({0})",
    SELECT: "wmr_two_pick({0}, {1}, {2})",
}
"""Operations on pairs as C."""
CHOSEN = "wmr_two_choose({0}, {1}, {2})"
"""A choice in which each has its own condition."""
COMPARED = {ca.OP_LT: "wmr_two_lt({0}, {1})", ca.OP_LE: "wmr_two_le({0}, {1})"}
"""Comparisons of pairs, as conditions of such choices."""


@dataclass(frozen=True, eq=False)
class PairStore(Item):
    """Two results side by side, as one."""

    vector: str = ""
    index: int = 0
    values: Two = (0, 0)


@dataclass(frozen=True)
class Paired:
    """Items with pairs; name of each pair, and the pair and position of each value in one.

    ``masks``: pairs of conditions.
    """

    items: list[Item]
    names: dict[Two, str]
    masks: dict[Two, Pair]
    place: dict[int, tuple[str, int]]


def in_pairs(graph: Graph, items: Sequence[Item]) -> Paired:
    """The items, where what is alike is computed in pairs."""
    pairing = _Pairing(graph, items)
    stores, singles = list[Item](), list[Item]()
    results = [item for item in items if isinstance(item, ResultStore)]
    waiting = list(results)
    while waiting:
        first, second = waiting[0], waiting[1] if len(waiting) > 1 else None
        two = second and pairing.stored(first, second)
        if two is None:
            singles.append(waiting.pop(0))
            continue
        stores.append(two)
        del waiting[:2]
    pairing.join_twins()
    pairing.go_on()
    others = [item for item in items if not isinstance(item, ResultStore)]
    listed = replaced([*others, *singles, *stores], pairing.made)
    return Paired(_needed(listed), pairing.names, pairing.masks, pairing.place)


def _needed(items: Sequence[Item]) -> list[Item]:
    """Those that results hang on: a comparison of a pair leaves its single ones without readers."""
    found, read = list[Item](), set[int]()
    for item in reversed(items):
        if not item.defines or not read.isdisjoint(item.defines):
            found.append(item)
            read |= item.reads
    return found[::-1]


class _Pairing:
    def __init__(self, graph: Graph, items: Sequence[Item]) -> None:
        self.graph, self.made = graph, list[Pair]()
        self.lines = {item.node for item in items if isinstance(item, Operation)}
        self.depth, self.readers = depths(items), dict[int, list[int]]()
        for number in self.lines:
            for operand in computed(graph, graph.nodes[number].operands):
                self.readers.setdefault(operand, []).append(number)
        self.names, self.maker = dict[Two, str](), dict[Two, Pair]()
        self.masks = dict[Two, Pair]()
        self.place = dict[int, tuple[str, int]]()
        self.halves = dict[int, int]()
        self.placed = {node.place: k for k, node in enumerate(graph.nodes) if node.place}

    def stored(self, first: ResultStore, second: ResultStore) -> PairStore | None:
        """Two results that are stored as a pair; None where they do not lie side by side."""
        one, other = first.store, second.store
        if (one.vector, one.index + 1) != (other.vector, other.index) or one.node == other.node:
            return None
        two = one.node, other.node
        if two not in self.names:
            if self.beside(two) is None and not self._alike(two) and not self._apart(two):
                return None
            self.pair(two)
        return PairStore((), self._reads(two), 1, one.vector, one.index, two)

    def join_twins(self) -> None:
        """Make pairs of exponentials that nothing paired yet, and of choices between these."""
        groups: dict[tuple[int, ...], list[int]] = {}
        for number in sorted(self.lines - self.place.keys()):
            node = self.graph.nodes[number]
            if node.op in (ca.OP_EXPM1, SELECT):
                key = node.op, self.depth[number], *node.operands[: node.op == SELECT]
                groups.setdefault(key, []).append(number)
        for key in sorted(groups, key=lambda key: key[0] == SELECT):
            two = tuple(groups[key])
            if len(two) == 2 and (key[0] != SELECT or self._between_pairs(two)):
                self.pair(two)

    def go_on(self) -> None:
        """Make pairs of like operations on the halves of pairs, and on what both have in common."""
        nodes = self.graph.nodes
        found = {(nodes[number].op, nodes[number].operands): number for number in self.lines}
        for number in sorted(self.lines):
            node = nodes[number]
            for others in product(*map(self._seconds, node.operands)):
                if others != node.operands and (node.op, others) in found:
                    self.pair((number, found[node.op, others]))
                    break

    def _seconds(self, number: int) -> tuple[int, ...]:
        """Second half of the pair of which this is the first; else itself, or what is beside."""
        if number in self.place:
            _, k = self.place[number]
            return (number if k else self.halves[number],)
        vector, index = self.graph.nodes[number].place or ("", 0)
        beside = self.placed.get((vector, index + 1))
        return (number,) if beside is None else (number, beside)

    def _between_pairs(self, two: Two) -> bool:
        return any(o in self.names or self.beside(o) for o in self._operands(two)[1:])

    def pair(self, two: Two) -> None:
        """Make a pair of two values, and of what they are computed from, where they are alike."""
        waiting, begun = [(two, False)], set[Two]()
        while waiting:
            own, ready = waiting.pop()
            known = own in self.names or own[0] == own[1] or self.beside(own) is not None
            if known or (own in begun and not ready):
                continue
            begun.add(own)
            if not self._alike(own):
                self._add(own, None, (own,), (computed(self.graph, own),))
                if self._apart(own):  # what they are computed from may be alike all the same
                    waiting += [(other, False) for other in self._operands(own)]
            elif ready:  # by now neither value is in another pair
                operands = self._operands(own)
                needs = tuple(map(self._reads, operands))
                if self._is_choice(own):
                    needs = frozenset(self._mask(operands[0]).defines), *needs[1:]
                self._add(own, self.graph.nodes[own[0]].op, operands, needs)
                self.place |= {number: (self.names[own], k) for k, number in enumerate(own)}
                self.halves |= {own[0]: own[1], own[1]: own[0]}
            else:
                waiting.append((own, True))
                operands = self._operands(own)
                if self._is_choice(own):
                    operands = *self._operands(operands[0]), *operands[1:]
                waiting += [(other, False) for other in operands]

    def beside(self, two: Two) -> tuple[str, int] | None:
        """Vector and place at which these values lie side by side, if they do."""
        one, other = (self.graph.nodes[number].place for number in two)
        if one is None or other != (one[0], one[1] + 1):
            return None
        return one

    def _add(
        self, two: Two, op: int | None, operands: tuple[Two, ...], needs: tuple[frozenset[int], ...]
    ) -> None:
        self.names[two] = f"r{len(self.made) + 1}"
        defines = (-1 - len(self.made),) if op is None else two
        reads = frozenset().union(*needs)
        made = Pair(defines, reads, 2, self.names[two], op, operands, needs)
        self.made.append(made)
        self.maker[two] = made

    def _reads(self, two: Two) -> frozenset[int]:
        if two in self.names:
            return frozenset(self.maker[two].defines)
        return computed(self.graph, two)

    def _alike(self, two: Two) -> bool:
        """True where these values are free lines of one operation.

        And of one depth (`_levelled`): then neither needs the other, and no pairs need each other.
        """
        nodes = [self.graph.nodes[number] for number in two]
        return (
            all(number in self.lines and number not in self.place for number in two)
            and nodes[0].op == nodes[1].op
            and nodes[0].op in PAIRED
            and not any(map(self.graph.is_logical, two))
            and (nodes[0].op != SELECT or self._compared(*map(_condition, nodes)))
            and self._levelled(two)
        )

    def _levelled(self, two: Two) -> bool:
        """True where these values are of one depth, or can be: one sinks, with all that read it.

        Halves of a pair sink together.  Where one of the two would sink below the other, it needs
        the other, or their pair would need itself.
        """
        most = max(self.depth[number] for number in two)
        before, waiting = dict[int, int](), [(number, most) for number in two]
        while waiting:
            number, depth = waiting.pop()
            if self.depth[number] >= depth:
                continue
            if number in two and depth > most:
                self.depth |= before
                return False
            before.setdefault(number, self.depth[number])
            self.depth[number] = depth
            waiting += [(reader, depth + 1) for reader in self.readers.get(number, ())]
            if number in self.halves:
                waiting.append((self.halves[number], depth))
        return True

    def _compared(self, one: int, other: int) -> bool:
        """True where pairs can be chosen by these conditions: one, or two comparisons alike."""
        ops = {self.graph.nodes[number].op for number in (one, other)}
        depths = {self.depth.get(number) for number in (one, other)}
        return one == other or (len(ops) == len(depths) == 1 and ops <= set(COMPARED))

    def _is_choice(self, two: Two) -> bool:
        """True for a choice in which each has its own condition."""
        nodes = [self.graph.nodes[number] for number in two]
        return nodes[0].op == SELECT and _condition(nodes[0]) != _condition(nodes[1])

    def _mask(self, two: Two) -> Pair:
        """The pair of conditions of two comparisons, whose operands are pairs by now."""
        if two not in self.masks:
            operands, name = self._operands(two), f"r{len(self.made) + 1}"
            needs = tuple(map(self._reads, operands))
            reads, mark = frozenset().union(*needs), -1 - len(self.made)
            op = self.graph.nodes[two[0]].op
            self.masks[two] = Pair((mark,), reads, 2, name, op, operands, needs)
            self.made.append(self.masks[two])
        return self.masks[two]

    def _apart(self, two: Two) -> bool:
        """True for lines of one operation of which one needs more to be computed before."""
        ops = {self.graph.nodes[number].op for number in two}
        return len(ops) == 1 and all(number in self.lines for number in two)

    def _operands(self, two: Two) -> tuple[Two, ...]:
        one, other = (self.graph.nodes[number].operands for number in two)
        return tuple(zip(one, other, strict=True))


def _condition(node: Node) -> int:
    return node.operands[0]
