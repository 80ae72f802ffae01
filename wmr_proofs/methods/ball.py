"""INTERVAL: branch and bound with intervals over a box.

The box is split until every goal is proved on every part, or one is refuted.
"""

from collections.abc import Callable, Hashable, Mapping
from fractions import Fraction
from math import inf, isfinite, nextafter
from typing import Any

from flint import arb

from wmr_ctrl.results.ledger import OPEN, PROVED, REFUTED
from wmr_proofs.graph import Arithmetic, Ask, UndecidedError, Walk, paths
from wmr_proofs.statement import ABOVE, EQUAL, Statement

from . import interval as iv
from .interval import Interval
from .point import first_violation, judge
from .spec import Ball, Finding


class EmptyWayError(Exception):
    """The conditions assumed on this path contradict each other on the whole box."""


class IntervalArithmetic(Arithmetic):
    """Values over a box; assuming a condition narrows the compared values.

    With ``doubles``, inputs are doubles: x < y means that x is at most the double below y.
    """

    def __init__(self, box: Mapping[str, tuple[float, float]], doubles: bool) -> None:
        self.box, self.doubles = box, doubles
        self.count = 0
        self.known: dict[tuple[Hashable, ...], int] = {}
        self.narrowed: dict[int, tuple[float, float]] = {}
        self.inputs: dict[str, Interval] = {}

    def constant(self, value: float) -> Interval:
        """A double."""
        return Interval(value, value)

    def variable(self, name: str) -> Interval:
        """Range of an input."""
        if name not in self.inputs:
            self.inputs[name] = Interval(*self.box[name], self._fresh())
        return self.inputs[name]

    def apply(self, op: str, args: list[Any]) -> Interval | None:
        """Enclosure of an operation; None if it may be undefined."""
        for arg in args:
            if arg is None:
                return None
        given = [self._now(arg) for arg in args] if self.narrowed else args
        if op not in _OPERATIONS:
            raise UndecidedError(f"no enclosure of {op} is known")
        found = _OPERATIONS[op](*given)
        if found is None or not (isfinite(found.lo) and isfinite(found.hi)):
            return None
        if not found.key:
            found.key = self._name(op, given)
        return found

    def compare(self, op: str, left: Any, right: Any, ask: Ask) -> bool:
        """Truth of a comparison; if undecided, both paths are taken, each with narrowed values."""
        if left is None or right is None:
            raise UndecidedError("a comparison of what may be undefined")
        a, b = self._now(left), self._now(right)
        known = _decided(op, a, b)
        if known is not None:
            return known
        truth = ask((op, a.key or ("number", a.lo), b.key or ("number", b.lo)))
        if op in ("lt", "le"):  # a < b, a <= b or their opposites, as bounds for named quantities
            strict = self.doubles and (op == "lt") == truth
            small, large = (a, b) if truth else (b, a)
            self._bound(small, -inf, iv.down(large.hi) if strict else large.hi)
            self._bound(large, iv.up(small.lo) if strict else small.lo, inf)
        return truth

    def number(self, condition: bool) -> Interval:
        """1 or 0."""
        return Interval(float(condition), float(condition))

    def _fresh(self) -> int:
        self.count += 1
        return self.count

    def _name(self, op: str, args: list[Interval]) -> int:
        """Name of an operation on quantities; equal operations share it, so that forms combine."""
        name: tuple[Hashable, ...] = (op, *[arg.key or ("number", arg.lo) for arg in args])
        if op == "sub" and (op, name[2], name[1]) in self.known:
            return -self.known[op, name[2], name[1]]
        if name not in self.known:
            self.known[name] = self._fresh()
        return self.known[name]

    def _now(self, value: Interval) -> Interval:
        """The value, narrowed by the conditions assumed since."""
        if abs(value.key) not in self.narrowed:
            return value
        low, high = self.narrowed[abs(value.key)]
        if value.key < 0:
            low, high = -high, -low
        low, high = max(value.lo, low), min(value.hi, high)
        if low > high:
            raise EmptyWayError
        return Interval(low, high, value.key, value.form)

    def _bound(self, value: Interval, low: float, high: float) -> None:
        if not value.key:
            return
        if value.key < 0:
            low, high = -high, -low
        old = self.narrowed.get(abs(value.key), (-inf, inf))
        self.narrowed[abs(value.key)] = (max(old[0], low), min(old[1], high))


def _decided(op: str, a: Interval, b: Interval) -> bool | None:
    if op in ("eq", "ne"):
        same = a.lo == a.hi == b.lo == b.hi
        apart = a.hi < b.lo or b.hi < a.lo
        return None if not (same or apart) else (same == (op == "eq"))
    if a.hi < b.lo or (op == "le" and a.hi <= b.lo):
        return True
    if b.hi < a.lo or (op == "lt" and b.hi <= a.lo):
        return False
    return None


def _times(a: Interval, b: Interval) -> Interval:
    for one, other in ((a, b), (b, a)):
        if one.lo == one.hi == 1.0:
            return other
        if one.lo == one.hi == -1.0:
            return iv.negative(other)
    return iv.multiply(a, b)


_OPERATIONS: dict[str, Callable[..., Interval | None]] = {
    "add": iv.add,
    "sub": lambda a, b: iv.add(a, iv.negative(b)),
    "mul": _times,
    "div": iv.divide,
    "inv": lambda a: iv.divide(Interval(1.0, 1.0), a),
    "neg": iv.negative,
    "sq": lambda a: iv.multiply(iv.magnitude(a), iv.magnitude(a)),
    "twice": lambda a: iv.multiply(Interval(2.0, 2.0), a),
    "assign": lambda a: a,
    "fabs": iv.magnitude,
    "sqrt": iv.root,
    "fmin": iv.smaller,
    "fmax": lambda a, b: iv.negative(iv.smaller(iv.negative(a), iv.negative(b))),
    "log": lambda a: iv.elementary(arb.log, a) if a.lo > 0 else None,
    "exp": lambda a: iv.elementary(arb.exp, a),
    "tanh": lambda a: iv.elementary(arb.tanh, a),
    "sin": lambda a: iv.elementary(arb.sin, a, monotone=False),
    "cos": lambda a: iv.elementary(arb.cos, a, monotone=False),
}


Box = dict[str, tuple[float, float]]
WAYS = 64
ALL_OF = 64
"""Undecided parts that are all searched for a counterexample."""
ONE_IN = 16
"""Number of later parts of which one is searched."""


def decide(statement: Statement, method: Ball) -> Finding:
    """PROVED if no part is left, REFUTED by an exact point, OPEN if the budget is spent."""
    whole = {name: (_beyond(low, -inf), _beyond(high, inf))
             for name, (low, high) in method.box.items()}  # fmt: skip
    pending, count, unsure = [whole], 0, 0
    for name, places in method.cuts_at.items():  # where the graph changes its form
        for place in places:
            pending = [part for box in pending for part in _cut(box, name, float(place))]
    while pending:
        box = pending.pop()
        count += 1
        if _holds_on(statement, box, method.float_mode):
            continue
        unsure += 1
        searched = unsure <= ALL_OF or unsure % ONE_IN == 0
        point = first_violation(statement, _probes(box, statement)) if searched else None
        if point is not None:
            return Finding(REFUTED, {"boxes": count}, point)
        if count + len(pending) >= method.budget:
            return Finding(OPEN, {"boxes": count, "boxes left": len(pending) + 1})
        # Cut the side that is longest compared with the whole.
        share = {n: (b - a) / ((whole[n][1] - whole[n][0]) or inf) for n, (a, b) in box.items()}
        name = max(method.split or tuple(box), key=share.__getitem__)
        pending.extend(_cut(box, name, 0.5 * (box[name][0] + box[name][1])))
    witness = (p for p in _probes(whole, statement) if judge(statement, p)[0])
    return Finding(PROVED, {"boxes": count}, next(witness, None))


def _holds_on(statement: Statement, box: Box, doubles: bool) -> bool:
    """True if all goals hold on all paths; a hypothesis that cannot hold closes a path."""

    def run(ask: Ask) -> bool:
        try:
            values = Walk(statement.graph, IntervalArithmetic(box, doubles), ask).outputs()
        except EmptyWayError:
            return True
        given = zip(statement.given_kinds, values[len(statement.goal_kinds) :], strict=True)
        for kind, value in given:
            if value is None:
                continue
            if value.hi < 0 or (value.lo > 0 if kind == EQUAL else kind == ABOVE and value.hi <= 0):
                return True  # no point of the box is spoken of
        goals = zip(statement.goal_kinds, values, strict=False)
        return all(_certain(kind, value) for kind, value in goals)

    try:
        return all(result for _, result in paths(run, WAYS))
    except UndecidedError:
        return False


def _certain(kind: str, value: Interval | None) -> bool:
    if value is None:
        return False
    if kind == EQUAL:
        return value.lo == value.hi == 0
    return value.lo > 0 if kind == ABOVE else value.lo >= 0


def _cut(box: Box, name: str, place: float) -> list[Box]:
    low, high = box[name]
    if not low < place < high:
        return [box]
    return [{**box, name: (low, place)}, {**box, name: (place, high)}]


def _probes(box: Box, statement: Statement) -> list[dict[str, Fraction]]:
    """The middle and two opposite corners."""
    names = statement.graph.input_names
    shares = (Fraction(1, 2), Fraction(1), Fraction(0))
    ends = {n: (Fraction(box[n][0]), Fraction(box[n][1])) for n in names}
    return [{n: low + share * (high - low) for n, (low, high) in ends.items()} for share in shares]


def _beyond(value: Fraction, end: float) -> float:
    """The double next to a number on the side of ``end``, which is -inf or inf."""
    near = float(value)
    return nextafter(near, end) if (Fraction(near) - value) * (1 if end > 0 else -1) < 0 else near
