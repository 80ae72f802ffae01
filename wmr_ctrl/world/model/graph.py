"""A CasADi function as single assignments, which are compiled and are the subject of proofs.

CasADi lists instructions on reused work slots and writes a choice as (c ? a : 0) + (!c ? b : 0).
Here every value has one number, equal expressions share it, a choice is one operation, and
quotients by parameters are written as the compiler should see them. Nothing else in the package
reads CasADi's instructions.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca

PARAMETERS = "p"
"""Name of the input vector that stays the same during a run."""

SELECT = -1
"""Operation (condition, value if true, value if false); all others are CasADi's."""

LOGICAL = frozenset(
    {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_NOT}
)  # fmt: skip
_CALLS = frozenset(
    {
        ca.OP_EXP, ca.OP_LOG, ca.OP_LOG1P, ca.OP_EXPM1, ca.OP_SIN, ca.OP_COS, ca.OP_TAN,
        ca.OP_TANH, ca.OP_SINH, ca.OP_COSH, ca.OP_ASIN, ca.OP_ACOS, ca.OP_ATAN, ca.OP_ATAN2,
        ca.OP_POW, ca.OP_CONSTPOW, ca.OP_HYPOT,
    }
)  # fmt: skip
_SLOW = frozenset({ca.OP_DIV, ca.OP_INV, ca.OP_SQRT})
_SPECIAL = frozenset(
    {ca.OP_OUTPUT, ca.OP_INPUT, ca.OP_CONST, ca.OP_ASSIGN, ca.OP_IF_ELSE_ZERO, ca.OP_ADD}
)
PLAIN, STEADY, CHANGING = 0, 1, 2
"""A value is a plain number, stays the same during a run, or changes."""


class Node(NamedTuple):
    """One value: operation and operands, a constant's number, or an input's vector and index."""

    op: int
    operands: tuple[int, ...] = ()
    number: float = 0.0
    place: tuple[str, int] | None = None

    @property
    def leaf(self) -> bool:
        """True for a constant or an input, which take no statement."""
        return self.op in (ca.OP_CONST, ca.OP_INPUT)


@dataclass(frozen=True)
class Store:
    """A result: element ``index`` of vector ``vector`` takes the value ``node``."""

    vector: str
    index: int
    node: int


@dataclass(frozen=True)
class Graph:
    """Values in an order of execution, and the results among them."""

    nodes: tuple[Node, ...]
    stores: tuple[Store, ...]

    def is_logical(self, number: int) -> bool:
        """True for a truth value: a comparison, or a choice between such."""
        node = self.nodes[number]
        if node.op != SELECT:
            return node.op in LOGICAL
        bits = [Node(ca.OP_CONST, number=0.0), Node(ca.OP_CONST, number=1.0)]
        arms = [arm for arm in node.operands[1:] if self.nodes[arm] not in bits]
        return bool(arms) and all(self.is_logical(arm) for arm in arms)

    def cost(self, number: int) -> int:
        """Approximate cost of one operation: 20 for a call, 5 for a division or root, else 1."""
        op = self.nodes[number].op
        return 20 if op in _CALLS else 5 if op in _SLOW else 1


def read(function: ca.Function, inputs: Iterable[str], outputs: Iterable[str]) -> Graph:
    """The graph of an SX function whose vectors have these names, without unused values."""
    reader = _Reader(function, tuple(inputs), tuple(outputs))
    return without_unused(*_with_reciprocals(reader.into.nodes, reader.stores))


class _Numbering:
    """Numbering of values, each once."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._known: dict[tuple[object, ...], int] = {}

    def number_of(
        self,
        op: int,
        operands: tuple[int, ...] = (),
        number: float = 0.0,
        place: tuple[str, int] | None = None,
    ) -> int:
        """Number of a value; a new number for a new value."""
        key = (op, operands) if operands else (op, repr(number), place)
        own = self._known.get(key)
        if own is None:
            own = self._known[key] = len(self.nodes)
            self.nodes.append(Node(op, operands, number, place))
        return own


class _Reader:
    def __init__(
        self, function: ca.Function, inputs: tuple[str, ...], outputs: tuple[str, ...]
    ) -> None:
        self.into = _Numbering()
        self.stores: list[Store] = []
        number_of, slots = self.into.number_of, dict[int, int]()
        code, output, given = (
            function.instruction_id, function.instruction_output, function.instruction_input
        )  # fmt: skip
        for k in range(function.n_instructions()):
            op, into, operands = code(k), output(k), given(k)
            if op not in _SPECIAL:
                slots[into[0]] = number_of(op, tuple([slots[i] for i in operands]))
            elif op == ca.OP_OUTPUT:
                self.stores.append(Store(outputs[into[0]], into[1], slots[operands[0]]))
            elif op == ca.OP_INPUT:
                slots[into[0]] = number_of(op, place=(inputs[operands[0]], operands[1]))
            elif op == ca.OP_CONST:
                slots[into[0]] = number_of(op, number=function.instruction_constant(k))
            else:
                slots[into[0]] = self._chosen(op, tuple([slots[i] for i in operands]))

    def _chosen(self, op: int, operands: tuple[int, ...]) -> int:
        """Number of an assignment, of a conditional, or of an operation that may be a choice."""
        if op == ca.OP_ASSIGN:
            return operands[0]
        if op == ca.OP_IF_ELSE_ZERO:
            zero = self.into.number_of(ca.OP_CONST, number=0.0)
            return self.into.number_of(SELECT, (*operands, zero))
        chosen = self._choice(*operands)
        return self.into.number_of(SELECT, chosen) if chosen else self.into.number_of(op, operands)

    def _choice(self, left: int, right: int) -> tuple[int, ...] | None:
        """Operands of (c ? a : 0) + (!c ? b : 0), in either order, as one choice; else None."""
        if not (self._zero_else(left) and self._zero_else(right)):
            return None
        for first, second in ((left, right), (right, left)):
            one, other = self.into.nodes[first], self.into.nodes[second]
            negated = self.into.nodes[other.operands[0]]
            if negated.op == ca.OP_NOT and negated.operands[0] == one.operands[0]:
                return (*one.operands[:2], other.operands[1])
        return None

    def _zero_else(self, number: int) -> bool:
        node = self.into.nodes[number]
        if node.op != SELECT:
            return False
        last = self.into.nodes[node.operands[2]]
        return last.op == ca.OP_CONST and last.number == 0.0


def _with_reciprocals(nodes: list[Node], stores: list[Store]) -> tuple[list[Node], list[Store]]:
    """Quotients of a changing value by a parameter (or an expression of parameters) as products.

    ``a / b`` becomes ``a * (1 / b)`` if b is constant during a run and a is not: a division takes
    as long as three multiplications, and these are in chains.  The rule depends only on a and b, so
    an expression is computed equally in every function.
    """
    kind = kinds(nodes)
    rewritten = {
        number
        for number, node in enumerate(nodes)
        if node.op == ca.OP_DIV and [kind[k] for k in node.operands] == [CHANGING, STEADY]
    }
    if not rewritten:
        return nodes, stores
    into = _Numbering()
    new: list[int] = []
    for number, node in enumerate(nodes):
        operands = tuple([new[k] for k in node.operands])
        if number in rewritten:
            inverse = into.number_of(ca.OP_INV, operands[1:])
            new.append(into.number_of(ca.OP_MUL, (operands[0], inverse)))
        else:
            new.append(into.number_of(node.op, operands, node.number, node.place))
    return into.nodes, [Store(item.vector, item.index, new[item.node]) for item in stores]


def kinds(nodes: Iterable[Node]) -> list[int]:
    """Kind of each value: PLAIN, STEADY or CHANGING."""
    listed: list[int] = []
    for node in nodes:
        if node.place is not None:
            listed.append(STEADY if node.place[0] == PARAMETERS else CHANGING)
        else:
            listed.append(max((listed[k] for k in node.operands), default=PLAIN))
    return listed


def without_unused(nodes: list[Node], stores: list[Store]) -> Graph:
    """The graph with only those values that the results need."""
    live = {item.node for item in stores}
    for number in range(len(nodes) - 1, -1, -1):
        if number in live:
            live.update(nodes[number].operands)
    if len(live) == len(nodes):
        return Graph(tuple(nodes), tuple(stores))
    new = {old: place for place, old in enumerate(sorted(live))}
    used = (nodes[old] for old in new)
    rest = (Node(n.op, tuple([new[old] for old in n.operands]), n.number, n.place) for n in used)
    return Graph(tuple(rest), tuple(Store(s.vector, s.index, new[s.node]) for s in stores))


_ROUNDING = frozenset({ca.OP_FLOOR, ca.OP_CEIL})


def rounds(expr: ca.SX, varying: ca.SX) -> bool:
    """True if some element of a column rounds an expression that depends on ``varying``."""
    return _unrounded(expr, varying)[1]


def unrounded(expr: ca.SX, varying: ca.SX) -> ca.SX:
    """The column without rounding of expressions that depend on ``varying``."""
    return _unrounded(expr, varying)[0]


def _unrounded(expr: ca.SX, varying: ca.SX) -> tuple[ca.SX, bool]:
    """Results of `unrounded` and `rounds`, by one walk through the instructions."""
    fixed = [item for item in ca.symvar(expr) if not ca.depends_on(varying, item)]
    inputs = [varying, *fixed]
    f = ca.Function("f", inputs, [ca.densify(expr)])
    slots: dict[int, tuple[ca.SX, bool]] = {}
    into, rounding = [ca.SX(0)] * expr.numel(), False
    for k in range(f.n_instructions()):
        op, place, used = f.instruction_id(k), f.instruction_output(k), f.instruction_input(k)
        if op == ca.OP_OUTPUT:
            into[place[1]] = slots[used[0]][0]
        elif op == ca.OP_INPUT:
            slots[place[0]] = inputs[used[0]][used[1]], used[0] == 0
        elif op == ca.OP_CONST:
            slots[place[0]] = ca.SX(f.instruction_constant(k)), False
        else:
            operands, varies = [slots[i][0] for i in used], any(slots[i][1] for i in used)
            rounded = varies and op in _ROUNDING
            rounding |= rounded
            if rounded or op == ca.OP_ASSIGN:
                value = operands[0]
            else:
                value = (ca.SX.unary if len(operands) == 1 else ca.SX.binary)(op, *operands)
            slots[place[0]] = value, varies
    return ca.vertcat(*into) if into else ca.SX(0, 1), rounding
