"""POINT: a graph at one exact point, in rationals if possible and in 300-bit balls otherwise.

A counterexample must pass this test: hypotheses certainly true, a goal certainly violated.
"""

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from math import isqrt
from typing import Any

from flint import arb, ctx, fmpq

from wmr_ctrl.results.ledger import OPEN, PROVED, REFUTED
from wmr_proofs.graph import ARITHMETIC, COMPARE, Arithmetic, Ask, UndecidedError, Walk
from wmr_proofs.statement import ABOVE, EQUAL, Statement

from .spec import Finding, Point, Refute, Table

BITS = 300


class Pi:
    """A rational multiple of pi, so that its sine and cosine stay exact."""

    def __init__(self, times: Fraction) -> None:
        self.times = times

    def ball(self) -> arb:
        """Enclosure."""
        return arb.pi() * _ball(self.times)


class PointArithmetic(Arithmetic):
    """Exact rationals; balls after an irrational operation."""

    def __init__(self, point: Mapping[str, Any]) -> None:
        self.point = point

    def constant(self, value: float) -> Any:
        """The double, exactly."""
        return Fraction(value) if abs(value) < float("inf") else arb(value)

    def variable(self, name: str) -> Any:
        """Coordinate of the point."""
        value = self.point[name]
        return Pi(Fraction(value.split()[0])) if isinstance(value, str) else value

    def apply(self, op: str, args: list[Any]) -> Any:
        """Exact if every operand is rational and the operation keeps it so."""
        if all(type(a) is arb for a in args):
            return _of_balls(op, args)
        if any(isinstance(a, Pi) for a in args):
            args = [_unwrap(op, a) for a in args]
        if all(isinstance(a, Fraction) for a in args):
            exact = _rational(op, args)
            if exact is not None:
                return exact
        if op in ("sin", "cos") and isinstance(args[0], Pi):
            quarter = int(2 * args[0].times) + (1 if op == "cos" else 0)
            return Fraction((0, 1, 0, -1)[quarter % 4])
        return _of_balls(op, [_ball(a) for a in args])

    def compare(self, op: str, left: Any, right: Any, _ask: Ask) -> bool:
        """Certain truth; UndecidedError otherwise."""
        return bool(COMPARE[op](sign_of(self.apply("sub", [left, right])), 0))

    def merge(self, condition: Any, yes: Any, no: Any) -> Any:
        """Choice by a condition that is a number; nonzero means true."""
        return yes if sign_of(condition) != 0 else no

    def number(self, condition: bool) -> Fraction:
        """1 or 0."""
        return Fraction(int(condition))


def decide_points(statement: Statement, method: Refute) -> Finding:
    """REFUTED by the first point that satisfies every hypothesis and violates a goal."""
    found = first_violation(statement, method.points)
    return Finding(OPEN if found is None else REFUTED, {"points tried": len(method.points)}, found)


def first_violation(statement: Statement, points: Iterable[Point]) -> Point | None:
    """The first exact counterexample among ``points``."""
    for point in points:
        given, goal = judge(statement, point)
        if given and not goal:
            return point
    return None


def decide_table(statement: Statement, method: Table) -> Finding:
    """PROVED if it is true at every point, REFUTED by the first at which it is certainly false."""
    points = method.points()
    for point in points:
        # Coordinates that are doubles as exact balls are faster.
        balls = {name: arb(v) if isinstance(v, float) else v for name, v in point.items()}
        if certainly(statement, balls) or certainly(statement, _exact(point)):
            continue
        given, goal = judge(statement, _exact(point))
        found = _exact(point) if given and not goal else None
        return Finding(REFUTED if found else OPEN, {"points": len(points)}, found)
    return Finding(PROVED, {"points": len(points)}, _exact(points[0]))


def _exact(point: Point) -> Point:
    return {name: Fraction(v) if isinstance(v, float) else v for name, v in point.items()}


def evaluate(statement: Statement, point: Mapping[str, Any]) -> list[Any]:
    """Values of the goals, then of the hypotheses, at ``point`` (rationals or `Pi`)."""
    ctx.prec = BITS
    return Walk(statement.graph, PointArithmetic(point), lambda _: False).outputs()


def holds(kind: str, value: Any) -> bool:
    """True if ``value`` certainly has relation ``kind`` to 0; UndecidedError if uncertain."""
    s = sign_of(value)
    return s == 0 if kind == EQUAL else (s > 0 if kind == ABOVE else s >= 0)


def judge(statement: Statement, point: Mapping[str, Any]) -> tuple[bool, bool]:
    """(all hypotheses hold, all goals hold) at ``point``; uncertain hypotheses count as false.

    A goal that cannot be distinguished from its bound counts as true: no refutation is based on it.
    """
    met, kept = judged(statement, point)
    return met, all(kept)


def judged(statement: Statement, point: Mapping[str, Any]) -> tuple[bool, tuple[bool, ...]]:
    """`judge` with the truth of each goal."""
    try:
        values = evaluate(statement, point)
    except (UndecidedError, ZeroDivisionError):
        return False, (True,) * len(statement.goal_kinds)
    goals = len(statement.goal_kinds)
    given = zip(statement.given_kinds, values[goals:], strict=True)
    asked = zip(statement.goal_kinds, values[:goals], strict=True)
    met = all(_certain(kind, v, False) for kind, v in given)
    return met, tuple(_certain(kind, v, True) for kind, v in asked)


def certainly(statement: Statement, point: Mapping[str, Any]) -> bool:
    """True if hypotheses and goals all certainly hold at ``point``."""
    try:
        values = evaluate(statement, point)
    except (UndecidedError, ZeroDivisionError):
        return False
    kinds = (*statement.goal_kinds, *statement.given_kinds)
    return all(_certain(kind, value, False) for kind, value in zip(kinds, values, strict=True))


def _certain(kind: str, value: Any, default: bool) -> bool:
    try:
        return holds(kind, value)
    except UndecidedError:
        return default


def sign_of(value: Any) -> int:
    """-1, 0 or 1, if certain."""
    if isinstance(value, Pi):
        value = value.times
    if type(value) is not arb and isinstance(value, Fraction):
        return (value > 0) - (value < 0)
    if value > 0:
        return 1
    if value < 0:
        return -1
    if value.is_zero():
        return 0
    raise UndecidedError("sign not certain")


def _ball(value: Any) -> arb:
    if type(value) is arb:
        return value
    if isinstance(value, Pi):
        return value.ball()
    return arb(fmpq(value.numerator, value.denominator)) if isinstance(value, Fraction) else value


def _unwrap(op: str, value: Any) -> Any:
    """Convert a multiple of pi for the operation: quarter turns keep sine and cosine rational."""
    if not isinstance(value, Pi):
        return value
    if op in ("sin", "cos") and (2 * value.times).denominator == 1:
        return value
    return value.ball()


def _rational(op: str, args: list[Any]) -> Fraction | None:
    if (op == "div" and args[1] == 0) or (op == "inv" and args[0] == 0):
        raise UndecidedError("division by zero")
    found: Fraction | None = _RATIONAL[op](*args) if op in _RATIONAL else None
    return found


def _power(a: Fraction, b: Fraction) -> Fraction | None:
    return a ** int(b) if b.denominator == 1 and (a != 0 or b > 0) else None


def _exact_root(a: Fraction) -> Fraction | None:
    if a < 0:
        raise UndecidedError("root of a negative number")
    root = Fraction(isqrt(a.numerator), isqrt(a.denominator))
    return root if root * root == a else None


def _of_balls(op: str, args: list[arb]) -> Any:
    if op not in _BALLS:
        raise UndecidedError(f"operation {op} has no exact evaluation")
    found = _BALLS[op](*args)
    if isinstance(found, arb) and not found.is_finite():
        raise UndecidedError(f"{op} outside its domain")
    return found


_RATIONAL: dict[str, Callable[..., Any]] = {
    **ARITHMETIC,
    "fabs": abs,
    "fmin": min,
    "fmax": max,
    "sign": lambda a: Fraction((a > 0) - (a < 0)),
    "sqrt": _exact_root,
    **dict.fromkeys(("sin", "tanh", "log1p", "expm1"), lambda a: a if a == 0 else None),
    **dict.fromkeys(("cos", "exp"), lambda a: Fraction(1) if a == 0 else None),
    "log": lambda a: Fraction(0) if a == 1 else None,
    "constpow": _power,
    "pow": _power,
}
_BALLS: dict[str, Callable[..., Any]] = {
    **ARITHMETIC,
    "fabs": abs,
    "fmin": arb.min,
    "fmax": arb.max,
    **{n: getattr(arb, n) for n in ("sqrt", "sin", "cos", "exp", "log", "tanh", "log1p", "expm1")},
    "sign": lambda a: Fraction(sign_of(a)),
    "constpow": lambda a, b: a ** int(b),
    "pow": lambda a, b: a**b,
}
