"""Items of one function as lines of C."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from wmr_ctrl.codegen.branches import branched
from wmr_ctrl.codegen.dialect import TRUTHS, Dialect
from wmr_ctrl.codegen.fold import folded
from wmr_ctrl.codegen.interleave import interleave, turns
from wmr_ctrl.codegen.items import (
    Four,
    IfElse,
    Item,
    Operation,
    Roll,
    Slice,
    Together,
    Turn,
    Writing,
    operation,
    ordered,
    writing,
)
from wmr_ctrl.codegen.reroll import in_fours, rolled
from wmr_ctrl.model.graph import SELECT, Graph

_STEP = "    "


def body(graph: Graph, dialect: Dialect) -> list[str]:
    """Statements of a function that computes the graph: branches, loops, and results last."""
    lines = [operation(graph, k) for k, node in enumerate(graph.nodes) if not node.leaf]
    scope = ordered([*lines, *(writing(graph, store) for store in graph.stores)])
    scope = branched(graph, scope)
    scope = interleave(graph, scope) if dialect.together else scope
    items, places = rolled(graph, turns(graph, scope) if dialect.turns else scope)
    items = in_fours(items, places) if dialect.fours else items
    return _Writer(graph, dialect, items, places).text()


class _Writer:
    """Writes the items of one function."""

    def __init__(
        self,
        graph: Graph,
        dialect: Dialect,
        items: Sequence[Item],
        places: dict[int, tuple[str, int]],
    ) -> None:
        self.graph, self.dialect, self.items, self.places = graph, dialect, items, places
        self.grouped = {
            number: (item.array, index)
            for item in items
            if isinstance(item, Together)
            for index, number in enumerate(item.defines)
        }
        self.folded = folded(graph, items)
        self.rolls = [item for item in items if isinstance(item, Roll) and item.defines]

    def text(self) -> list[str]:
        """All lines, with the local arrays first."""
        return [*self._arrays(), *self._lines(self.items, _STEP)]

    def _arrays(self) -> list[str]:
        gone = {number for roll in self.folded for number in roll.defines}
        sizes: dict[str, int] = {}
        for number, (array, index) in self.places.items():
            if number not in gone:
                sizes[array] = max(sizes.get(array, 0), index + 1)
        return [f"{_STEP}{self.dialect.real} {name}[{size}];" for name, size in sizes.items()]

    def _lines(self, items: Iterable[Item], indent: str) -> list[str]:
        found: list[str] = []
        for item in items:
            if isinstance(item, Operation):
                found.append(indent + self._assignment(item.node))
            elif isinstance(item, Writing):
                target = f"{item.store.vector}[{item.store.index}]"
                found.append(f"{indent}{target} = {self._real(item.store.node)};")
            elif isinstance(item, IfElse):
                found.extend(self._block(item, indent))
            elif isinstance(item, Four):
                found.append(
                    f"{indent}{self._four(item.target, map(self._expression, item.defines))}"
                )
            elif isinstance(item, Turn):
                sine, cosine = map(self._name, item.defines)
                found.append(f"{indent}{self.dialect.real} {sine}, {cosine};")
                called = f"wmr_sin_cos({self._real(item.angle)}, &{sine}, &{cosine});"
                found.append(f"{indent}{called}")
            elif isinstance(item, Together):
                found.extend(self._exponentials(item, indent))
            elif isinstance(item, Roll) and item not in self.folded:
                found.extend(self._loop(item, indent))
        return found

    def _exponentials(self, item: Together, indent: str) -> list[str]:
        """What is missing to a multiple of the dialect's size is filled up with zeros."""
        given = [self._real(number) for number in item.operands]
        given += [self.dialect.number(0.0)] * (-len(given) % self.dialect.together)
        name, size = f"{self.dialect.real} {item.array}", len(given)
        called = f"{indent}wmr_exp_many({item.array}, {size});"
        if not self.dialect.fours:
            return [f"{indent}{name}[{size}] = {{{', '.join(given)}}};", called]
        fours = [
            indent + self._four(Slice(item.array, k), given[k : k + 4]) for k in range(0, size, 4)
        ]
        return [f"{indent}{name}[{size}];", *fours, called]

    def _four(self, target: Slice, given: Iterable[str]) -> str:
        at = f"{target.array} + {target.start}" if target.start else target.array
        return f"wmr_four({at}, {', '.join(given)});"

    def _assignment(self, number: int) -> str:
        if number in self.places:
            return f"{self._name(number)} = {self._expression(number)};"
        return f"const {self._type(number)} {self._name(number)} = {self._expression(number)};"

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
            return f"{place[0]}[{place[1]}]"
        return self.dialect.number(node.number) if node.leaf else f"t{number}"

    def _real(self, number: int) -> str:
        name = self._name(number)
        return self.dialect.as_real(name) if self.graph.is_logical(number) else name

    def _truth(self, number: int) -> str:
        name = self._name(number)
        return name if self.graph.is_logical(number) else self.dialect.as_truth(name)

    def _loop(self, roll: Roll, indent: str) -> list[str]:
        target = f"{roll.target.array}[{_shifted(roll.target.start)}]"
        head = f"{indent}for (int j = 0; j < {roll.length}; ++j) {{"
        return [head, f"{indent}{_STEP}{target} = {self._rolled(roll, 0)};", f"{indent}}}"]

    def _rolled(self, roll: Roll, shift: int) -> str:
        """Element ``shift + j`` of a loop's result."""
        shown = [self._element(operand, shift) for operand in roll.operands]
        return shown[0] if roll.op is None else self.dialect.pattern(roll.op).format(*shown)

    def _element(self, operand: Slice | int, shift: int) -> str:
        if isinstance(operand, int):
            return self._real(operand)
        inner = self._folded_at(operand.array, operand.start + shift)
        if inner is not None:
            return f"({self._rolled(inner, operand.start + shift - inner.target.start)})"
        return f"{operand.array}[{_shifted(operand.start + shift)}]"

    def _folded_at(self, array: str, index: int) -> Roll | None:
        for roll in self.rolls:
            start = roll.target.start
            if roll.target.array == array and start <= index < start + roll.length:
                return roll if roll in self.folded else None
        return None

    def _block(self, block: IfElse, indent: str) -> list[str]:
        return (self._lane_block if self.dialect.lanes else self._branch)(block, indent)

    def _branch(self, block: IfElse, indent: str) -> list[str]:
        found = [f"{indent}{self._type(k)} {self._name(k)};" for k in block.defines]
        found.append(f"{indent}if ({self._truth(block.condition)}) {{")
        found += self._arm(block.then, block.defines, 1, indent + _STEP)
        found.append(f"{indent}}} else {{")
        found += self._arm(block.other, block.defines, 2, indent + _STEP)
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
        """Each side where any lane wants it; the second is put in by lane."""
        condition, inner = self._truth(block.condition), indent + _STEP
        found = [
            f"{indent}{self._type(k)} {self._name(k)} = {self._nothing(k)};" for k in block.defines
        ]
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

    def _nothing(self, number: int) -> str:
        zero = self.dialect.number(0.0)
        return self.dialect.as_truth(zero) if self.graph.is_logical(number) else zero


def _shifted(start: int) -> str:
    return f"j + {start}" if start else "j"
