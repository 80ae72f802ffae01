"""Branch and bound: a box is cut until every goal holds on every part, or one is refuted."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from fractions import Fraction
from math import inf, nextafter

from wmr_ctrl.proofs.finding import OPEN, PROVED, REFUTED, Finding
from wmr_ctrl.proofs.methods.interval import Interval
from wmr_ctrl.proofs.methods.interval_arithmetic import EmptyWayError, IntervalArithmetic
from wmr_ctrl.proofs.methods.point import first_violation, judge
from wmr_ctrl.proofs.methods.spec import Ball
from wmr_ctrl.proofs.statement import ABOVE, EQUAL, Statement
from wmr_ctrl.proofs.walk import UndecidedError, Walk, paths

Box = dict[str, tuple[float, float]]
WAYS = 64
ALL_OF, ONE_IN = 64, 16
"""A counterexample is looked for in the first parts that are not shown, then in one of so many."""


def decide(statement: Statement, method: Ball) -> Finding:
    """PROVED when no part is left, REFUTED by an exact point of a part, OPEN out of budget."""
    whole = {name: (_below(low), _above(high)) for name, (low, high) in method.box.items()}
    pending, count, unsure = _first_cuts(whole, method), 0, 0
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
        pending.extend(_halves(box, whole, method))
    witness = (p for p in _probes(whole, statement) if judge(statement, p)[0])
    return Finding(PROVED, {"boxes": count}, next(witness, None))


def _holds_on(statement: Statement, box: Box, doubles: bool) -> bool:
    """All goals on all ways, where a hypothesis that cannot hold closes a way."""

    def run(ask: Callable[[Hashable], bool]) -> bool:
        try:
            values = Walk(statement.graph, IntervalArithmetic(box, doubles), ask).outputs()
        except EmptyWayError:
            return True
        given = zip(statement.given_kinds, values[len(statement.goals) :], strict=True)
        if any(_impossible(kind, value) for kind, value in given):
            return True
        return all(
            _certain(kind, value) for kind, value in zip(statement.goal_kinds, values, strict=False)
        )

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


def _impossible(kind: str, value: Interval | None) -> bool:
    if value is None:
        return False
    return (value.hi < 0 or (kind == EQUAL and value.lo > 0)) or (kind == ABOVE and value.hi <= 0)


def _first_cuts(whole: Box, method: Ball) -> list[Box]:
    """The box cut at the coordinates where the graph changes its form."""
    found = [whole]
    for name, places in method.cuts_at.items():
        for place in places:
            found = [part for box in found for part in _cut(box, name, float(place))]
    return found


def _cut(box: Box, name: str, place: float) -> list[Box]:
    low, high = box[name]
    if not low < place < high:
        return [box]
    return [{**box, name: (low, place)}, {**box, name: (place, high)}]


def _halves(box: Box, whole: Box, method: Ball) -> list[Box]:
    """Cut the side that is longest compared with the whole."""
    names = method.split or tuple(box)
    name = max(names, key=lambda n: (box[n][1] - box[n][0]) / ((whole[n][1] - whole[n][0]) or inf))
    return _cut(box, name, 0.5 * (box[name][0] + box[name][1]))


def _probes(box: Box, statement: Statement) -> list[dict[str, Fraction]]:
    """The middle and two opposite corners."""
    names = statement.graph.input_names
    shares = (Fraction(1, 2), Fraction(1), Fraction(0))
    ends = {n: (Fraction(box[n][0]), Fraction(box[n][1])) for n in names}
    return [{n: low + share * (high - low) for n, (low, high) in ends.items()} for share in shares]


def _below(value: Fraction) -> float:
    near = float(value)
    return near if Fraction(near) <= value else nextafter(near, -inf)


def _above(value: Fraction) -> float:
    near = float(value)
    return near if Fraction(near) >= value else nextafter(near, inf)
