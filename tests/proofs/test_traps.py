"""Statements that each method must leave open: undefined somewhere, undecided or unsupported."""

from fractions import Fraction

import casadi as ca
import pytest

from wmr_proofs.methods.spec import Z3, Ball, Refute, Ring, Table
from wmr_proofs.regions import NONNEGATIVE, Case, at
from wmr_proofs.statement import Statement, above, at_least, equal, symbols

UNIT = {name: (Fraction(0), Fraction(1)) for name in ("x", "y")}
NOT_NEGATIVE = Ring((Case("x, y >= 0", declared={"x": NONNEGATIVE, "y": NONNEGATIVE}),))


def about(*goals, given=()):
    return Statement(T, goals, tuple(given))


T = symbols("x y")
X, Y = T.values()
NOWHERE = above(X), above(-X)
MOTZKIN = X**4 * Y**2 + X**2 * Y**4 + 1 - 3 * X**2 * Y**2
SINGULAR = (
    about(equal((X**2 - Y**2) / (X - Y), X + Y)),
    about(equal((X * Y + X) / X, Y + 1)),
    about(equal((ca.sqrt(X - Y) + 1) * (ca.sqrt(X - Y) - 1), X - Y - 1)),
    about(equal((X - Y + 1) / (X - Y) - 1 / (X - Y), 1)),
    about(at_least(X**2 / X - X)),
)
"""True wherever they mean something, but not everywhere."""
UNKNOWN = (
    about(at_least(ca.exp(X), 1 + X)),
    about(at_least(X**2, ca.tanh(X) ** 2)),
    about(at_least(ca.cos(X), 1 - X**2 / 2)),
    about(at_least(X**2, ca.sin(X) ** 2)),
    about(at_least(ca.log(2 + X**2))),
    about(at_least(ca.floor(X) + 1, X)),
)
"""True, but not to be had from the few facts that the exact methods know."""
RING_ONLY = (
    about(at_least(MOTZKIN)),
    about(equal(ca.if_else(X, 1, 2), 1)),
    about(equal(ca.if_else(ca.logic_and(X, Y), 1, 2), 1)),
)
Z3_ONLY = (
    about(equal(ca.sin(X + Y), ca.sin(X) * ca.cos(Y) + ca.cos(X) * ca.sin(Y))),
    about(equal(ca.exp(X + Y), ca.exp(X) * ca.exp(Y))),
    about(above(X, 5), given=NOWHERE),
    about(at_least(X**0.3 + 1), given=(above(X),)),
)
BALL = (
    about(at_least(0.25, X * (1 - X))),
    about(at_least(ca.exp(X), 1 + X)),
    about(at_least(1 / X)),
    about(at_least(-ca.log(X))),
    about(at_least(ca.sqrt(X - 0.5))),
    about(equal(2 * ca.sin(X) * ca.cos(X), ca.sin(2 * X))),
    about(at_least(1, X / (X + Y))),
    about(at_least(ca.fabs(X) / X)),
    about(at_least(X**Y)),
    about(at_least(ca.tan(X))),
    about(at_least(ca.if_else(X * Y >= 0, 1, -1), ca.if_else(X / Y >= 0, 1, 0))),
)
AT_ONE = Table(lambda: (at(x=1, y=2),))
AT_ZERO = Table(lambda: (at(x=0, y=0),))
POINTS = (
    (AT_ONE, about(equal(ca.exp(X) * ca.exp(-X), 1))),
    (AT_ONE, about(equal((ca.sqrt(Y) + 1) * (ca.sqrt(Y) - 1), 1))),
    (AT_ONE, about(equal(2 * ca.sin(X) * ca.cos(X), ca.sin(2 * X)))),
    (AT_ONE, about(at_least(ca.log(ca.exp(X) * ca.exp(Y)), 3))),
    (AT_ONE, about(at_least(ca.if_else(ca.exp(X) * ca.exp(-X) >= 1, 1, -1)))),
    (AT_ZERO, about(at_least(1 / X))),
    (AT_ZERO, about(equal(X / Y, 0))),
    (AT_ZERO, about(at_least(-ca.log(X)))),
    (AT_ZERO, about(at_least(ca.sqrt(X - 1)))),
    (AT_ZERO, about(at_least(X ** (-1.0)))),
    (Refute((at(x=-2, y=0),)), about(above(X), given=(above(X, -1),))),
    (Refute((at(x=0, y=0),)), about(above(1 / X))),
    (Refute((at(x=1, y=2),)), about(above(1, ca.exp(X) * ca.exp(-X)))),
    (Refute((at(x=1, y=2),)), about(above(-X), given=(above(1, ca.exp(X) * ca.exp(-X)),))),
    (Refute(()), about(above(X))),
)


@pytest.mark.parametrize("statement", [*SINGULAR, *UNKNOWN, *RING_ONLY])
def test_exact_algebra_leaves_open(statement):
    assert NOT_NEGATIVE.decide(statement).verdict == "OPEN"
    assert Ring().decide(statement).verdict == "OPEN"


@pytest.mark.parametrize("statement", [*SINGULAR, *UNKNOWN, *Z3_ONLY])
def test_z3_leaves_open(statement):
    assert Z3(effort=5).decide(statement).verdict == "OPEN"


@pytest.mark.parametrize("statement", BALL)
def test_intervals_leave_open(statement):
    assert Ball(box=UNIT, budget=100).decide(statement).verdict == "OPEN"


@pytest.mark.parametrize("method, statement", POINTS)
def test_points_leave_open(method, statement):
    assert method.decide(statement).verdict == "OPEN"


@pytest.mark.parametrize("method", [Ball(box=UNIT), Ring(), Z3()])
def test_a_choice_by_a_number_takes_both_ways(method):
    chosen = about(at_least(2, ca.if_else(X, 5, Y)), given=(at_least(1, Y),))

    assert method.decide(chosen).verdict != "PROVED"
