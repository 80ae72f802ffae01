"""A graph in Modelica: the algorithm of a function, or equations of a block.

It is the graph of the C kernels, with the same branches and loops.  A function computes only what
is needed, since Modelica tools stop at the logarithm of a negative number even if a choice discards
it.
"""

import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

import casadi as ca

from wmr_ctrl.codegen.dialect import SCALAR, TRUTHS
from wmr_ctrl.codegen.items import (
    ArrayLoop,
    IfElse,
    Item,
    Operation,
    ResultStore,
    Slice,
    branched,
    statements,
)
from wmr_ctrl.codegen.reroll import reroll
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.model.graph import SELECT, Graph

LARGEST = 1e300
"""Replacement for infinity, which Modelica lacks."""
_LONGEST = 56
"""Characters of an expression that is written where it is used, if it is used once."""
_STEP = "  "
_PATTERNS = {op: text.replace("wmr_", "") for op, text in SCALAR.patterns.items()} | {
    ca.OP_POW: "{0} ^ {1}", ca.OP_CONSTPOW: "{0} ^ {1}", ca.OP_NE: "{0} <> {1}",
    ca.OP_AND: "{0} and {1}", ca.OP_OR: "{0} or {1}", ca.OP_NOT: "not {0}",
}  # fmt: skip
"""Operations as in C, except for powers and for Modelica's own signs."""
_TWICE_READ = frozenset({ca.OP_SQ})
"""Operations whose pattern names an operand twice."""

Names = Callable[[str, int], str]


def literal(value: float) -> str:
    """A number in Modelica syntax."""
    return repr(min(max(float(value), -LARGEST), LARGEST))


def constant(value: float) -> str:
    """A number within an expression, in parentheses if negative."""
    text = literal(value)
    return f"({text})" if text.startswith("-") else text


def indexed(vector: str, index: int) -> str:
    """Element ``index``, from 0, of a Modelica vector, which counts from 1."""
    return f"{vector}[{index + 1}]"


def algorithm(graph: Graph) -> tuple[list[str], list[str]]:
    """Local declarations and statements of a function; vectors have the graph's names."""
    items, places = reroll(graph, branched(graph, statements(graph), worth=1))
    writer = _Statements(graph, indexed, ":=", places, items)
    lines = writer.statements(items, _STEP)
    return writer.declarations(), lines


def equations(graph: Graph, names: Names, results: Mapping[tuple[str, int], str]) -> list[str]:
    """Equations of a block; ``results`` has the left side for each result of the graph.

    A value with several readers is a variable ``t<number>`` that is declared with the rest.  Raises
    ArgumentError for a graph with choices, which would be events.
    """
    if any(node.op == SELECT for node in graph.nodes):
        raise ArgumentError("a graph with choices has no equations: give it as a function.")
    items = statements(graph)
    writer = _Statements(graph, names, "=", {}, items, results)
    return writer.statements(items, "")


class _Statements:
    """Writer of items; short expressions with one reader are inserted where they are read."""

    def __init__(
        self,
        graph: Graph,
        names: Names,
        sign: str,
        places: Mapping[int, tuple[str, int]],
        items: Sequence[Item],
        results: Mapping[tuple[str, int], str] | None = None,
    ) -> None:
        self.graph, self.names, self.sign, self.places = graph, names, sign, places
        self.results = results
        self.kinds: dict[str, str] = {}
        self.inlined: dict[int, str] = {}
        self.readers: Counter[int] = Counter()
        self._count(items)

    def declarations(self) -> list[str]:
        """Local variables of the function, arrays first."""
        sizes: dict[str, int] = {}
        for array, index in self.places.values():
            sizes[array] = max(sizes.get(array, 0), index + 1)
        arrays = [f"{name}[{size}]" for name, size in sizes.items()]
        lines = []
        for kind, first in (("Real", arrays), ("Boolean", [])):
            names = [*first, *(name for name, own in self.kinds.items() if own == kind)]
            wrapped = textwrap.wrap(", ".join(names), 80)
            lines += [f"{kind} {line.rstrip(',')};" for line in wrapped]
        return lines

    def statements(self, items: Iterable[Item], indent: str) -> list[str]:
        """Lines of one scope."""
        text: list[str] = []
        for item in items:
            if isinstance(item, Operation):
                text += self._line(item, indent)
            elif isinstance(item, ResultStore):
                value = _bare(self._real(item.store.node))
                text.append(f"{indent}{self._target(item)} {self.sign} {value};")
            elif isinstance(item, IfElse):
                text += self._block(item, indent)
            elif isinstance(item, ArrayLoop):
                text += self._roll(item, indent)
        return text

    def _count(self, items: Iterable[Item]) -> None:
        """Count the readers of each value; readers in another scope or a loop count twice."""
        for item in items:
            if isinstance(item, Operation):
                node = self.graph.nodes[item.node]
                self.readers.update(node.operands * (1 + (node.op in _TWICE_READ)))
            elif isinstance(item, IfElse):
                self._count((*item.then, *item.other))
                arms = [self.graph.nodes[k].operands[s] for k in item.defines for s in (1, 2)]
                self.readers.update((item.condition, *arms, *arms))
                for number in item.reads:
                    self.readers[number] += 2 * (number != item.condition)
            elif isinstance(item, ArrayLoop):
                self.readers.update([*item.reads] * 2)
            else:
                self.readers.update(item.reads)

    def _target(self, item: ResultStore) -> str:
        place = (item.store.vector, item.store.index)
        return indexed(*place) if self.results is None else self.results[place]

    def _line(self, item: Operation, indent: str) -> list[str]:
        text = self._expression(item.node)
        own = item.node in self.places
        if not own and self.readers[item.node] == 1 and len(text) <= _LONGEST:
            name, bracket, rest = text.partition("(")
            call = name.isalnum() and name.islower() and _closes_last(bracket + rest)
            self.inlined[item.node] = text if bracket and call else f"({text})"
            return []
        return [f"{indent}{self._assigned(item.node)} {self.sign} {text};"]

    def _assigned(self, number: int) -> str:
        """Name of a value on the left side; a new one is declared."""
        name = self._name(number)
        if number not in self.places:
            self.kinds[name] = "Boolean" if self.graph.is_logical(number) else "Real"
        return name

    def _expression(self, number: int) -> str:
        node = self.graph.nodes[number]
        if node.op == SELECT:
            arm = self._truth if self.graph.is_logical(number) else self._real
            condition, yes, no = node.operands
            return f"if {_bare(self._truth(condition))} then {arm(yes)} else {arm(no)}"
        if node.op not in _PATTERNS:
            raise ArgumentError(
                f"CasADi operation {node.op} has no Modelica form in export/modelica/statements.py."
            )
        given = self._truth if node.op in TRUTHS else self._real
        pattern = _PATTERNS[node.op]
        shown = [given(k) for k in node.operands]
        return pattern.format(*(map(_bare, shown) if "(" in pattern else shown))

    def _name(self, number: int) -> str:
        node = self.graph.nodes[number]
        if node.place is not None:
            return self.names(*node.place)
        if number in self.places:
            return indexed(*self.places[number])
        if number in self.inlined:
            return self.inlined[number]
        return constant(node.number) if node.leaf else f"t{number}"

    def _real(self, number: int) -> str:
        name = self._name(number)
        return f"(if {name} then 1.0 else 0.0)" if self.graph.is_logical(number) else name

    def _truth(self, number: int) -> str:
        name = self._name(number)
        return name if self.graph.is_logical(number) else f"({name} <> 0.0)"

    def _block(self, block: IfElse, indent: str) -> list[str]:
        text = [f"{indent}if {_bare(self._truth(block.condition))} then"]
        for side, (word, items) in enumerate((("else", block.then), ("end if;", block.other)), 1):
            text += self.statements(items, indent + _STEP)
            text += [
                f"{indent}{_STEP}{self._assigned(k)} {self.sign} {_bare(self._chosen(k, side))};"
                for k in block.defines
            ]
            text.append(f"{indent}{word}")
        return text

    def _chosen(self, choice: int, side: int) -> str:
        operand = self.graph.nodes[choice].operands[side]
        return self._truth(operand) if self.graph.is_logical(choice) else self._real(operand)

    def _roll(self, roll: ArrayLoop, indent: str) -> list[str]:
        shown = [
            self._real(item) if isinstance(item, int) else _moving(item) for item in roll.operands
        ]
        value = shown[0] if roll.op is None else _PATTERNS[roll.op].format(*shown)
        return [
            f"{indent}for j in 1:{roll.length} loop",
            f"{indent}{_STEP}{_moving(roll.target)} {self.sign} {value};",
            f"{indent}end for;",
        ]


def _moving(part: Slice) -> str:
    return f"{part.array}[j + {part.start}]" if part.start else f"{part.array}[j]"


def _bare(text: str) -> str:
    """An expression without enclosing parentheses."""
    return text[1:-1] if text.startswith("(") and _closes_last(text) else text


def _closes_last(text: str) -> bool:
    """True if the last character closes the first parenthesis."""
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return place == len(text) - 1
    return False
