"""Statement: what a claim says, as relations between expressions of the product's own graphs."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca

from wmr_ctrl.proofs.graph import ProvedGraph, graph_of
from wmr_ctrl.proofs.rounded import UNIT, linked, rounded

EQUAL, AT_LEAST, ABOVE = "=", ">=", ">"


@dataclass(frozen=True)
class Relation:
    """``expr`` compared with 0: ``=``, ``>=`` or ``>``."""

    expr: ca.SX
    kind: str


def equal(left: ca.SX | float, right: ca.SX | float = 0) -> Relation:
    """left = right."""
    return Relation(ca.SX(left) - right, EQUAL)


def at_least(left: ca.SX | float, right: ca.SX | float = 0) -> Relation:
    """left >= right."""
    return Relation(ca.SX(left) - right, AT_LEAST)


def above(left: ca.SX | float, right: ca.SX | float = 0) -> Relation:
    """left > right."""
    return Relation(ca.SX(left) - right, ABOVE)


def every(left: ca.SX, right: ca.SX) -> tuple[Relation, ...]:
    """Element-wise equality of two columns."""
    both = ca.vec(left - right)
    return tuple(equal(both[i]) for i in range(both.numel()))


@dataclass(frozen=True)
class Statement:
    """For all ``symbols`` with ``given``: every goal holds.

    ``cuts`` names inner expressions that stand as free inputs: the statement is then shown for
    whatever value they have.  ``numbers`` are symbols with one value.  Each of the symbols named
    in ``computed`` is whatever the compiled text may compute for its expression, every operation
    rounded with a relative error of at most ``unit``.
    """

    symbols: Mapping[str, ca.SX]
    goals: tuple[Relation, ...]
    given: tuple[Relation, ...] = ()
    cuts: Mapping[str, ca.SX] = field(default_factory=dict)
    numbers: Mapping[str, float] = field(default_factory=dict)
    computed: Mapping[str, ca.SX] = field(default_factory=dict)
    unit: float = UNIT

    @cached_property
    def graph(self) -> ProvedGraph:
        """Outputs: the goals' expressions, those of ``given``, the bounds of all roundings."""
        exprs = [r.expr for r in (*self.goals, *self.given)]
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
        return tuple(r.kind for r in self.goals)

    @property
    def given_kinds(self) -> tuple[str, ...]:
        """Relation of each hypothesis to 0, the bounds of all roundings included."""
        roundings = len(self.graph.outputs) - len(self.goals) - len(self.given)
        return (*(r.kind for r in self.given), *[AT_LEAST] * roundings)


def symbols(names: str, fixed: str = "") -> dict[str, ca.SX]:
    """Fresh scalar symbols by name; those in ``fixed`` are parameters to the compiler."""
    known = set(fixed.split())
    return {name: ca.SX.sym(f"p.{name}" if name in known else name) for name in names.split()}


def column(name: str, size: int, fixed: bool = False) -> dict[str, ca.SX]:
    """Fresh scalar symbols name1 to name<size>; ``fixed`` makes them parameters."""
    names = " ".join(f"{name}{i}" for i in range(1, size + 1))
    return symbols(names, names if fixed else "")


def stacked(table: Mapping[str, ca.SX], name: str, size: int) -> ca.SX:
    """Column of name1 to name<size> out of a table."""
    return ca.vertcat(*(table[f"{name}{i}"] for i in range(1, size + 1)))
