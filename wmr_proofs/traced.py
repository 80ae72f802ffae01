"""Traced: a number with its expression, so that ordinary code builds a graph.

An effect's bound is computed from the numbers of a scenario.  If these are traced, the result is an
expression of symbols, valid for the path through the code that the numbers took: `Tracing.met` has
the result of each comparison on it.
"""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass, field
from functools import reduce
from math import isfinite, isinf
from types import SimpleNamespace
from typing import Any

import casadi as ca
from casadi import SX

from wmr_ctrl.world.scenario import Scenario

NEGATED = {"lt": "ge", "ge": "lt", "gt": "le", "le": "gt", "eq": "ne", "ne": "eq"}


@dataclass
class Tracing:
    """Symbols by the keys of their numbers, and the conditions that were met."""

    symbols: dict[str, SX] = field(default_factory=dict)
    met: list[SX] = field(default_factory=list)


class Traced(float):
    """A number, its expression, and the record of comparisons."""

    expr: SX
    trace: Tracing

    def __new__(cls, value: float, expr: SX, trace: Tracing) -> Traced:
        """The number ``value`` with the expression ``expr``."""
        made = super().__new__(cls, value)
        made.expr, made.trace = expr, trace
        return made

    __hash__ = float.__hash__

    def __neg__(self) -> Traced:
        return Traced(-float(self), -self.expr, self.trace)

    def __abs__(self) -> Traced:
        return Traced(abs(float(self)), abs(self.expr), self.trace)

    def __bool__(self) -> bool:
        return bool(self != 0.0)


def expression(number: float) -> SX:
    """The expression of a number, traced or not."""
    return number.expr if isinstance(number, Traced) else SX(number)


def _reckoned(apply: Callable[[Any, Any], Any], swapped: bool) -> Callable[[Traced, float], Traced]:
    def method(own: Traced, other: float) -> Traced:
        pair = (other, own) if swapped else (own, other)
        return Traced(apply(*map(float, pair)), apply(*map(expression, pair)), own.trace)

    return method


def _compared(name: str) -> Callable[[Traced, float], bool]:
    def method(own: Traced, other: float) -> bool:
        truth = bool(getattr(operator, name)(float(own), float(other)))
        if not isinf(other):  # of infinity a symbol is always on the same side
            found = getattr(operator, name if truth else NEGATED[name])
            own.trace.met.append(found(own.expr, expression(other)))
        return truth

    return method


for _name in ("add", "sub", "mul", "truediv"):
    setattr(Traced, f"__{_name}__", _reckoned(getattr(operator, _name), False))
    setattr(Traced, f"__r{_name}__", _reckoned(getattr(operator, _name), True))
for _name in NEGATED:
    setattr(Traced, f"__{_name}__", _compared(_name))


def _kept(name: str) -> Callable[[float], float]:
    """A function of ``math`` that preserves its argument's expression."""

    def call(x: float) -> float:
        value: float = getattr(math, name)(x)
        if isinstance(x, Traced):
            return Traced(value, getattr(ca, name)(x.expr), x.trace)
        return value

    return call


def _least(*values: Any) -> float:
    """The least number, as by ``min``; the expression is the minimum of the traced ones."""
    values = values if len(values) > 1 else tuple(values[0])
    given = [item for item in values if not isinf(item)]
    known = [item.trace for item in given if isinstance(item, Traced)]
    if not known:
        return min(values)
    return Traced(min(map(float, values)), reduce(ca.fmin, map(expression, given)), known[0])


@contextmanager
def functions_for_traced(package: str, but: str) -> Iterator[None]:
    """Context in which a package's modules have sin, expm1, min and float that preserve
    expressions.

    Their other ``math`` functions use a traced number as a float, and so do all functions of the
    module ``but``, which only checks results.
    """
    maths = SimpleNamespace(**(vars(math) | {name: _kept(name) for name in ("sin", "expm1")}))
    given = {"math": maths, "min": _least, "float": lambda x: x if type(x) is Traced else float(x)}
    named = (name for name in sys.modules if name.startswith(f"{package}.") and name != but)
    spaces = [vars(sys.modules[name]) for name in named]
    before = [{name: space[name] for name in given if name in space} for space in spaces]
    for space in spaces:
        space.update(
            {name: made for name, made in given.items() if name != "math" or name in space}
        )
    try:
        yield
    finally:
        for space, names in zip(spaces, before, strict=True):
            for name in given:
                space.pop(name, None)
            space.update(names)


def traced(
    scenario: Scenario, keys: tuple[str, ...], share: float = 1.0
) -> tuple[Scenario, Tracing]:
    """The scenario with symbols for the finite numbers of these tables.

    Their values, which select the path through the code, are the scenario's times ``share``.
    """
    trace = Tracing()

    def symbol(key: str, value: float) -> Traced:
        trace.symbols[key] = SX.sym(key)
        return Traced(value * share, trace.symbols[key], trace)

    def stands(value: object) -> bool:
        return isinstance(value, float | int) and not isinstance(value, bool) and isfinite(value)

    held = copy(scenario)
    for key in keys:
        table = copy(scenario.table(key))
        for name, value in vars(table).items():
            if stands(value):
                object.__setattr__(table, name, symbol(f"{key}.{name}", value))
            elif isinstance(value, tuple) and all(map(stands, value)):
                pair = (symbol(f"{key}.{name}[{i}]", item) for i, item in enumerate(value, 1))
                object.__setattr__(table, name, tuple(pair))
        if key in vars(scenario):
            object.__setattr__(held, key, table)
        else:
            object.__setattr__(held, "effects", {**held.effects, key: table})
    return held, trace
