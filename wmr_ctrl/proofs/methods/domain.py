"""Where a graph's operations are defined: what else has to be shown before a goal means anything.

A quotient needs a denominator that is not 0, a logarithm a positive argument, a root one that is
not negative, wherever the goal reads them: the untaken side of a choice asks for nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import z3

from wmr_ctrl.proofs.walk import Walk

_OUTSIDE: dict[str, Callable[..., Any]] = {
    "div": lambda _, below: below == 0,
    "inv": lambda below: below == 0,
    "log": lambda a: a <= 0,
    "sqrt": lambda a: a < 0,
}


def violations(walk: Walk, goals: int) -> Iterator[Any]:
    """Terms, each true where one operation behind the first ``goals`` outputs is undefined."""
    guards = _guards(walk, goals)
    for k, guard in guards.items():
        node = walk.graph.nodes[k]
        if node.op in _OUTSIDE:
            outside = z3.simplify(_OUTSIDE[node.op](*(walk.values[arg] for arg in node.args)))
            if not z3.is_false(outside):
                yield z3.And(guard, outside)


def _guards(walk: Walk, goals: int) -> dict[int, Any]:
    """Of each node that a goal needs, the condition under which it is read."""
    guards: dict[int, Any] = {
        k: z3.BoolVal(True, walk.values[k].ctx) for k in walk.graph.outputs[:goals]
    }
    for k in range(len(walk.graph.nodes) - 1, -1, -1):
        for arg, condition in _reads(walk, k) if k in guards else ():
            _add(guards, arg, guards[k] if condition is None else z3.And(guards[k], condition))
    return guards


def _reads(walk: Walk, k: int) -> Iterator[tuple[int, Any]]:
    """Operands of a node, each with the condition under which it is read (None: always)."""
    node = walk.graph.nodes[k]
    if node.op != "choose":
        yield from ((arg, None) for arg in node.args)
        return
    truth = walk.truth(node.args[0])
    yield node.args[0], None
    yield node.args[1], truth
    yield node.args[2], z3.Not(truth)


def _add(guards: dict[int, Any], k: int, condition: Any) -> None:
    if k not in guards:
        guards[k] = condition
    elif not z3.is_true(guards[k]):
        guards[k] = condition if z3.is_true(condition) else z3.Or(guards[k], condition)
