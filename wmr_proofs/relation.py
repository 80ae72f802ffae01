"""Relations between expressions, from which claims are built: comparisons, as ``V >= v_bar``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca

EQUAL, AT_LEAST, ABOVE = "=", ">=", ">"
Number: TypeAlias = ca.SX | float
Expressions: TypeAlias = Mapping[str, ca.SX]
"""Expressions by name."""
Cuts = dict[str, ca.SX]
"""The same, to be added to: expressions that become free inputs of a statement."""


@dataclass(frozen=True)
class Relation:
    """``expr`` compared with 0: ``=``, ``>=`` or ``>``."""

    expr: ca.SX
    kind: str


Relations: TypeAlias = "Relation | ca.SX | Sequence[Relations]"
"""One relation or comparison, or groups of them within groups, in their order."""
KINDS = {ca.OP_LE: AT_LEAST, ca.OP_LT: ABOVE, ca.OP_EQ: EQUAL}


def listed(relations: Relations) -> tuple[Relation, ...]:
    """Relations of all groups, in one list."""
    if isinstance(relations, Relation):
        return (relations,)
    if isinstance(relations, ca.SX):
        return (compared(relations),)
    return tuple(item for part in relations for item in listed(part))


def compared(truth: ca.SX) -> Relation:
    """What a comparison states; one that CasADi has decided is 0 = 0 or 1 = 0.

    ValueError for another expression.
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
    return Relation(ca.SX(left) - right, EQUAL)


def at_least(left: Number, right: Number = 0) -> Relation:
    """left >= right."""
    return Relation(ca.SX(left) - right, AT_LEAST)


def above(left: Number, right: Number = 0) -> Relation:
    """left > right."""
    return Relation(ca.SX(left) - right, ABOVE)


def positive(*exprs: Number) -> tuple[Relation, ...]:
    """Each of them > 0."""
    return tuple(map(above, exprs))


def nonnegative(*exprs: Number) -> tuple[Relation, ...]:
    """Each of them >= 0."""
    return tuple(map(at_least, exprs))


def between(low: Number, value: Number, high: Number) -> tuple[Relation, Relation]:
    """low <= value <= high."""
    return at_least(value, low), at_least(high, value)


def within(value: ca.SX, bound: Number) -> tuple[Relation, ...]:
    """|value| <= bound, for each element of a column."""
    most = ca.SX(bound) * ca.SX.ones(value.shape)
    pairs = zip(ca.vertsplit(value), ca.vertsplit(most), strict=True)
    return tuple(side for x, end in pairs for side in (at_least(end, x), at_least(x, -end)))


def when(condition: ca.SX, relations: Relations) -> tuple[Relation, ...]:
    """``condition`` implies the relations, which must be true for the expression 0."""
    found = listed(relations)
    return tuple(Relation(ca.if_else(condition, item.expr, 0), item.kind) for item in found)


def every(left: ca.SX, right: ca.SX) -> tuple[Relation, ...]:
    """Element-wise equality of two columns."""
    both = ca.vec(left - right)
    return tuple(equal(both[i]) for i in range(both.numel()))
