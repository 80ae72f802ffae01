"""RING: exact algebra, one case after the other, every way through undecided conditions."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from fractions import Fraction
from typing import Any

from wmr_ctrl.proofs.case import Case
from wmr_ctrl.proofs.finding import OPEN, PROVED, REFUTED, Finding
from wmr_ctrl.proofs.methods.log_lemma import at_least_by_lemma
from wmr_ctrl.proofs.methods.point import judge
from wmr_ctrl.proofs.methods.ring_arithmetic import RingArithmetic
from wmr_ctrl.proofs.methods.spec import Point, Ring
from wmr_ctrl.proofs.statement import ABOVE, EQUAL, Statement
from wmr_ctrl.proofs.walk import UndecidedError, Walk, paths

SAMPLES = 8


def decide(statement: Statement, method: Ring) -> Finding:
    """PROVED if every goal follows in every case; a failing case is searched for an exact point."""
    failed: list[Case] = []
    for case in method.cases:
        if not _proved(statement, method, case):
            failed.append(case)
            found = next(_violations(statement, [case]), None) if method.quick else None
            if found is not None:
                return Finding(REFUTED, {"first case not shown": case.label}, found)
    evidence = {"cases": len(method.cases), "cases not shown": len(failed)}
    if failed:
        found = next(_violations(statement, failed), None)
        return Finding(OPEN if found is None else REFUTED, evidence, found)
    witness = next(_witnesses(statement, method), None)
    return Finding(PROVED, evidence, witness)


def _proved(statement: Statement, method: Ring, case: Case) -> bool:
    names = tuple(n for n in statement.graph.input_names if n not in _assigned(case))
    shared = RingArithmetic(case, names, method.fixed, method.spare)

    def run(ask: Callable[[Hashable], bool]) -> bool:
        shared.ask = ask
        return _all_hold(statement, shared, ask, method.log_lemma)

    try:
        return all(result for _, result in paths(run))
    except UndecidedError:
        return False


def _all_hold(
    statement: Statement, arithmetic: RingArithmetic, ask: Callable[[Hashable], bool], lemma: bool
) -> bool:
    """Goals hold, and so do the hypotheses: a case must lie inside what the statement assumes."""
    values = Walk(statement.graph, arithmetic, ask).outputs()
    goals = zip(statement.goal_kinds, values, strict=False)
    given = zip(statement.given_kinds, values[len(statement.goals) :], strict=True)
    return all(_holds(arithmetic, kind, value, lemma) for kind, value in (*goals, *given))


def _holds(arithmetic: RingArithmetic, kind: str, value: Any, lemma: bool) -> bool:
    if value is None:
        return False
    value = arithmetic.algebra.reduced(value)
    if kind == EQUAL:
        return not value
    found = arithmetic.algebra.sign(value)
    if found is not None:
        return found in (("+",) if kind == ABOVE else ("+", "+0", "0"))
    return lemma and at_least_by_lemma(arithmetic.algebra, value, strict=kind == ABOVE)


def _assigned(case: Case) -> frozenset[str]:
    return frozenset(case.values(dict.fromkeys(case.numbers, Fraction(1))))


def _points(statement: Statement, case: Case) -> Iterator[Point]:
    for shift in range(SAMPLES):
        yield case.sample(statement.graph.input_names, shift)


def _violations(statement: Statement, cases: list[Case]) -> Iterator[Point]:
    for case in cases:
        for point in _points(statement, case):
            given, goal = judge(statement, point)
            if given and not goal:
                yield point


def _witnesses(statement: Statement, method: Ring) -> Iterator[Point]:
    """Points that keep the hypotheses (and, as a check of the algebra, the goals)."""
    for case in method.cases:
        point = next(_points(statement, case))
        given, goal = judge(statement, point)
        if given and not goal and not method.fixed:
            raise AssertionError(f"algebra and exact evaluation disagree at {point}")
        if given:
            yield point
