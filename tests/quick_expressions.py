"""CasADi's functions of scalar expressions, asked for without a search.

For `a * b` CasADi's Python layer tries each kind of number and matrix in turn before it takes the
expressions for what they are: 20 us, where the operation takes 2.  Tests build graphs by the
thousand, so for these kinds it is told.  The node that comes out is the same:
`test_no_committed_verdict_is_about_another_graph` and the golden packages compare graphs that were
recorded without this file, and tests/test_quick_expressions.py each function with CasADi's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
from casadi import casadi as layer

ONE = {
    "sqrt": ca.OP_SQRT, "fabs": ca.OP_FABS, "exp": ca.OP_EXP, "expm1": ca.OP_EXPM1,
    "log": ca.OP_LOG, "log1p": ca.OP_LOG1P, "sin": ca.OP_SIN, "cos": ca.OP_COS,
    "tan": ca.OP_TAN, "tanh": ca.OP_TANH, "floor": ca.OP_FLOOR, "logic_not": ca.OP_NOT,
}  # fmt: skip
TWO = {
    "plus": ca.OP_ADD, "minus": ca.OP_SUB, "times": ca.OP_MUL, "rdivide": ca.OP_DIV,
    "power": ca.OP_POW, "atan2": ca.OP_ATAN2, "fmin": ca.OP_FMIN, "fmax": ca.OP_FMAX,
    "lt": ca.OP_LT, "le": ca.OP_LE, "eq": ca.OP_EQ, "ne": ca.OP_NE,
    "logic_and": ca.OP_AND, "logic_or": ca.OP_OR,
}  # fmt: skip
NUMBERS = (float, int)
SEARCHED: Mapping[str, Callable[..., Any]] = {
    name: getattr(layer._casadi, name) for name in (*ONE, *TWO, "if_else")
}
"""CasADi's own, by name."""


def use() -> None:
    """From now on in this process."""
    for name, op in ONE.items():
        setattr(layer._casadi, name, _of_one(op, SEARCHED[name]))
    for name, op in TWO.items():
        setattr(layer._casadi, name, _of_two(op, SEARCHED[name]))
    layer._casadi.if_else = _choice(SEARCHED["if_else"])


def _of_one(op: int, searched: Callable[..., Any]) -> Callable[..., Any]:
    unary, sx = ca.SX.unary, ca.SX

    def function(*given: Any) -> Any:
        return unary(op, *given) if type(given[0]) is sx else searched(*given)

    return function


def _of_two(op: int, searched: Callable[..., Any]) -> Callable[..., Any]:
    binary, sx = ca.SX.binary, ca.SX

    def function(*given: Any) -> Any:
        a, b = (type(item) for item in given)
        known = (a is sx and (b is sx or b in NUMBERS)) or (b is sx and a in NUMBERS)
        return binary(op, *given) if known else searched(*given)

    return function


def _choice(searched: Callable[..., Any]) -> Callable[..., Any]:
    binary, unary, sx = ca.SX.binary, ca.SX.unary, ca.SX

    def if_else(*given: Any) -> Any:
        kinds = [type(item) for item in given]
        if len(kinds) != 3 or kinds[0] is not sx or not {*kinds} <= {sx, *NUMBERS}:
            return searched(*given)
        condition, one, other = given
        return binary(
            ca.OP_ADD,
            binary(ca.OP_IF_ELSE_ZERO, condition, one),
            binary(ca.OP_IF_ELSE_ZERO, unary(ca.OP_NOT, condition), other),
        )

    return if_else
