"""Statement of a claim: relations between expressions of the product's own graphs.

Relations are comparisons, such as ``V >= v_bar``.

For statements about computed numbers, every rounding operation becomes a separate input.  It stands
for any number within the unit of rounding of the exact result of that operation on such numbers.
This is the standard model of IEEE arithmetic without overflow and underflow.  A proof for all such
numbers is valid for the compiled text (`assumption.libm`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from math import frexp
from typing import TypeAlias

import casadi as ca
from casadi import SX, substitute, vertcat, vertsplit

from .graph import LOGICAL, Expressions, ProvedGraph, ProvedNode, graph_of

EQUAL, AT_LEAST, ABOVE = "=", ">=", ">"
Number: TypeAlias = SX | float
Cuts = dict[str, SX]
"""Expressions by name, to be added to: those that become free inputs of a statement."""


@dataclass(frozen=True)
class Relation:
    """``expr`` compared with 0: ``=``, ``>=`` or ``>``."""

    expr: SX
    kind: str


Relations: TypeAlias = "Relation | ca.SX | Sequence[Relations]"
"""One relation or comparison, or groups of them within groups, in their order."""
Group: TypeAlias = list[Relations]
"""Relations, to be added to."""
KINDS = {ca.OP_LE: AT_LEAST, ca.OP_LT: ABOVE, ca.OP_EQ: EQUAL}


def listed(relations: Relations) -> tuple[Relation, ...]:
    """Relations of all groups, in one list."""
    if isinstance(relations, Relation):
        return (relations,)
    if isinstance(relations, SX):
        return (compared(relations),)
    return tuple(item for part in relations for item in listed(part))


def compared(truth: SX) -> Relation:
    """The relation of a comparison; one that CasADi has decided becomes 0 = 0 or 1 = 0.

    Raises ValueError for another expression.
    """
    if truth.is_constant():
        return equal(1, truth)
    for operation, kind in KINDS.items():
        if truth.is_scalar() and truth.is_op(operation):
            left, right = truth.dep(0), truth.dep(1)
            return Relation(left - right if kind == EQUAL else right - left, kind)
    raise ValueError(f"no comparison of expressions: {truth}")


def equal(left: Number, right: Number = 0) -> Relation:
    """left = right."""
    return Relation(SX(left) - right, EQUAL)


def at_least(left: Number, right: Number = 0) -> Relation:
    """left >= right."""
    return Relation(SX(left) - right, AT_LEAST)


def above(left: Number, right: Number = 0) -> Relation:
    """left > right."""
    return Relation(SX(left) - right, ABOVE)


def positive(*exprs: Number) -> tuple[Relation, ...]:
    """Each of them > 0."""
    return tuple(map(above, exprs))


def nonnegative(*exprs: Number) -> tuple[Relation, ...]:
    """Each of them >= 0."""
    return tuple(map(at_least, exprs))


def between(low: Number, value: Number, high: Number) -> tuple[Relation, Relation]:
    """low <= value <= high."""
    return at_least(value, low), at_least(high, value)


def within(value: SX, bound: Number) -> tuple[Relation, ...]:
    """|value| <= bound, for each element of a column."""
    pairs = zip(vertsplit(value), vertsplit(SX(bound) * SX.ones(value.shape)), strict=True)
    return tuple(side for x, end in pairs for side in (at_least(end, x), at_least(x, -end)))


def when(condition: SX, relations: Relations) -> tuple[Relation, ...]:
    """``condition`` implies the relations."""
    return tuple(
        Relation(ca.if_else(condition, item.expr, item.kind == ABOVE), item.kind)
        for item in listed(relations)
    )


def every(left: SX, right: SX) -> tuple[Relation, ...]:
    """Element-wise equality of two columns."""
    both = ca.vec(left - right)
    return tuple(equal(both[i]) for i in range(both.numel()))


UNIT = 2.0**-53
"""Largest relative error of one operation in double precision."""

COMPUTED = "rounded "
EXACT = LOGICAL | {"const", "input", "neg", "fabs", "fmin", "fmax", "choose", "twice", "sign"}
ROUNDED = frozenset({"add", "sub", "mul", "div", "inv", "sq", "sqrt"})


@dataclass(frozen=True)
class RoundedGraph:
    """Nodes with an input for each rounding, the indices of the results, and the inputs' bounds.

    ``bounds`` are nodes that must not be negative: the unit times an exact result, less the
    distance of the computed one, for both signs.
    """

    nodes: tuple[ProvedNode, ...]
    outputs: tuple[int, ...]
    bounds: tuple[int, ...]


def rounded(graph: ProvedGraph, unit: float) -> RoundedGraph:
    """``graph`` as doubles compute it.  ValueError for an operation with an unknown error."""
    nodes: list[ProvedNode] = []
    place: list[int] = []
    bounds: list[int] = []

    def put(node: ProvedNode) -> int:
        nodes.append(node)
        return len(nodes) - 1

    for node in graph.nodes:
        exact = put(node._replace(args=tuple(place[k] for k in node.args)))
        factors = (graph.nodes[k] for k in node.args if node.op == "mul")
        scales = any(f.op == "const" and abs(frexp(f.value)[0]) == 0.5 for f in factors)
        if node.op in EXACT or scales:  # a product with a power of two is exact
            place.append(exact)
            continue
        if node.op not in ROUNDED:
            raise ValueError(f"how far {node.op} is rounded is not known")
        found = put(ProvedNode("input", name=f"{COMPUTED}{len(bounds) // 2 + 1}"))
        share = put(ProvedNode("mul", (put(ProvedNode("const", value=unit)),
                                       put(ProvedNode("fabs", (exact,))))))  # fmt: skip
        for pair in ((found, exact), (exact, found)):
            bounds.append(put(ProvedNode("sub", (share, put(ProvedNode("sub", pair))))))
        place.append(found)
    return RoundedGraph(tuple(nodes), tuple(place[k] for k in graph.outputs), tuple(bounds))


def behind(graph: ProvedGraph, k: int) -> tuple[int, ...]:
    """The exact operation whose computed result an input represents; it is just before the input.

    Such a result must be defined, although the graph ends at this input.
    """
    return (k - 1,) if graph.nodes[k].name.startswith(COMPUTED) else ()


def linked(graph: ProvedGraph, parts: RoundedGraph, names: Sequence[str]) -> ProvedGraph:
    """``graph`` with its inputs ``names`` replaced by computed results.

    Its outputs are followed by the bounds of all roundings.
    """
    results = dict(zip(names, parts.outputs, strict=True))
    nodes = list(parts.nodes)
    place: list[int] = []
    for node in graph.nodes:
        if node.op == "input" and node.name in results:
            place.append(results[node.name])
            continue
        nodes.append(node._replace(args=tuple(place[k] for k in node.args)))
        place.append(len(nodes) - 1)
    return ProvedGraph(tuple(nodes), (*(place[k] for k in graph.outputs), *parts.bounds))


@dataclass(frozen=True)
class Statement:
    """For all ``symbols`` with ``given``: every goal holds.

    ``cuts`` names inner expressions that become free inputs: the statement is then proved for all
    their values.  ``numbers`` are symbols with one value.  Each symbol named in ``computed`` is any
    number that the compiled text may compute for its expression, every operation rounded with a
    relative error of at most ``unit``.  ``parts``: see `joined`.
    """

    symbols: Expressions
    goals: Relations
    given: Relations = ()
    cuts: Expressions = field(default_factory=dict)
    numbers: Mapping[str, float] = field(default_factory=dict)
    computed: Expressions = field(default_factory=dict)
    unit: float = UNIT
    parts: Mapping[str, Statement] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("goals", "given"):
            object.__setattr__(self, name, listed(vars(self)[name]))

    @cached_property
    def graph(self) -> ProvedGraph:
        """Outputs: the goals' expressions, those of ``given``, the bounds of all roundings."""
        if self.parts:
            return _united(self.parts)
        exprs = [r.expr for r in listed((self.goals, self.given))]
        exact = graph_of(self.symbols, exprs, self.cuts, self.numbers)
        if not self.computed:
            return exact
        text = graph_of(self.symbols, [*self.computed.values()], self.cuts, self.numbers)
        return linked(exact, rounded(text, self.unit), [*self.computed])

    @property
    def digest(self) -> str:
        """sha256 of the graph, and of which outputs are goals or hypotheses, by which relation."""
        kinds = f"{self.graph.digest} {self.goal_kinds} {self.given_kinds}"
        return hashlib.sha256(kinds.encode()).hexdigest()

    @property
    def goal_kinds(self) -> tuple[str, ...]:
        """Relation of each goal to 0."""
        return tuple(r.kind for r in listed(self.goals))

    @property
    def given_kinds(self) -> tuple[str, ...]:
        """Relation of each hypothesis to 0, the bounds of all roundings included."""
        kinds = tuple(r.kind for r in listed(self.given))
        roundings = len(self.graph.outputs) - len(self.goal_kinds) - len(kinds)
        return kinds + (AT_LEAST,) * roundings


def joined(parts: Mapping[str, Statement]) -> Statement:
    """All of these statements, by name, each about its own symbols."""
    goals = [part.goals for part in parts.values()]
    return Statement({}, goals, [part.given for part in parts.values()], parts=parts)


def own_name(name: str, part: str) -> str:
    """Name of a part's symbol in the joined statement."""
    return f"{name}, {part}"


def own_point(point: Mapping[str, str], part: Statement, key: str) -> dict[str, str]:
    """Point of the part ``key`` from a point of the joined statement."""
    names = {own_name(name, key): name for name in part.graph.input_names}
    return {names[name]: value for name, value in point.items() if name in names}


def _united(parts: Mapping[str, Statement]) -> ProvedGraph:
    nodes: list[ProvedNode] = []
    goals, given, bounds = list[int](), list[int](), list[int]()
    for key, part in parts.items():
        start, graph = len(nodes), part.graph
        for node in graph.nodes:
            name = own_name(node.name, key) if node.name else ""
            nodes.append(node._replace(args=tuple(start + k for k in node.args), name=name))
        places = [start + k for k in graph.outputs]
        first = len(part.goal_kinds)
        second = first + len(listed(part.given))
        goals += places[:first]
        given += places[first:second]
        bounds += places[second:]
    return ProvedGraph(tuple(nodes), (*goals, *given, *bounds))


def instance(proved: Statement, values: Expressions) -> tuple[Relation, ...]:
    """Each goal of a proved statement, for these ``values`` of its symbols.

    A goal is true if all of the statement's hypotheses are true for the values; nothing is cut or
    computed in it.
    """
    given, goals = (valued(part, proved.symbols, values) for part in (proved.given, proved.goals))
    truth = {EQUAL: "eq", AT_LEAST: "ge", ABOVE: "gt"}
    met = reduce(ca.logic_and, [getattr(ca, truth[item.kind])(item.expr, 0) for item in given])
    return when(met, goals)


def valued(relations: Relations, names: Expressions, values: Expressions) -> tuple[Relation, ...]:
    """The relations with the symbols of these names replaced by ``values``."""
    old, stated = [names[name] for name in values], listed(relations)
    put = substitute([item.expr for item in stated], old, [*values.values()])
    return tuple(Relation(e, item.kind) for e, item in zip(put, stated, strict=True))


class Symbols(dict[str, SX]):
    """Scalar symbols by name, ``t["x"]`` or ``t.x``."""

    def __getattr__(self, name: str) -> SX:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    def __or__(self, more: Expressions) -> Symbols:  # type: ignore[override]
        return Symbols({**self, **more})

    def __ror__(self, more: Expressions) -> Symbols:  # type: ignore[override]
        return Symbols({**more, **self})


class Named(Expressions):
    """Base of a setting, which is the table of its ``symbols``; these are attributes, too.

    ``always`` are goals of each of its statements.
    """

    symbols: Symbols
    always: Relations = ()

    def __getitem__(self, name: str) -> SX:
        return self.symbols[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.symbols)

    def __len__(self) -> int:
        return len(self.symbols)

    def __or__(self, more: Expressions) -> Symbols:
        return self.symbols | more

    def __getattr__(self, name: str) -> SX:
        if name == "symbols":
            raise AttributeError(name)
        return getattr(self.symbols, name)

    def states(
        self,
        *goals: Relations,
        given: Relations = (),
        cuts: Expressions | None = None,
        more: Expressions | None = None,
    ) -> Statement:
        """The statement about these symbols and ``more``."""
        return Statement(self.symbols | (more or {}), (goals, self.always), given, cuts or {})


def symbols(names: str, fixed: str = "") -> Symbols:
    """Fresh scalar symbols by name; those in ``fixed`` are parameters for the compiler."""
    known = set(fixed.split())
    return Symbols({n: SX.sym(f"p.{n}" if n in known else n) for n in names.split()})


def column(name: str, size: int, fixed: bool = False) -> Symbols:
    """Fresh scalar symbols name1 to name<size>; ``fixed`` makes them parameters."""
    names = " ".join(f"{name}{i}" for i in range(1, size + 1))
    return symbols(names, names if fixed else "")


def exchanged(expr: SX, old: Expressions, new: Expressions) -> SX:
    """The expression with the symbols ``old`` replaced by those of equal name in ``new``."""
    both = [(old[name], new[name]) for name in old if name in new]
    return substitute(expr, *(vertcat(*side) for side in zip(*both, strict=True)))


def stacked(table: Expressions, name: str, size: int) -> SX:
    """Column of name1 to name<size> from a table."""
    return vertcat(*(table[f"{name}{i}"] for i in range(1, size + 1)))
