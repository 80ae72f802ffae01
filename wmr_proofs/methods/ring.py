"""RING: exact algebra, case by case, on every path through undecided conditions.

The only fact used about the logarithm is ln t >= 1 - 1/t (t > 0).
"""

from collections.abc import Iterator
from fractions import Fraction
from math import lcm
from typing import Any

from wmr_ctrl.results.ledger import OPEN, PROVED, REFUTED
from wmr_proofs.graph import Ask, UndecidedError, Walk, paths
from wmr_proofs.regions import Case
from wmr_proofs.statement import ABOVE, EQUAL, Statement

from .field import Algebra, Exponents, Quotient
from .point import first_violation, judge
from .ring_arithmetic import RingArithmetic
from .spec import Finding, Point, Ring

SAMPLES = 8


def decide(statement: Statement, method: Ring) -> Finding:
    """PROVED if every goal follows in every case; a failing case is searched for an exact point."""
    failed: list[Case] = []
    for case in method.cases:
        if not _proved(statement, method, case):
            failed.append(case)
            found = _violation(statement, [case]) if method.quick else None
            if found is not None:
                return Finding(REFUTED, {"first case not shown": case.label}, found)
    evidence = {"cases": len(method.cases), "cases not shown": len(failed)}
    if failed:
        found = _violation(statement, failed)
        return Finding(OPEN if found is None else REFUTED, evidence, found)
    return Finding(PROVED, evidence, next(_witnesses(statement, method), None))


def _proved(statement: Statement, method: Ring, case: Case) -> bool:
    assigned = case.values(dict.fromkeys(case.numbers, Fraction(1)))
    names = tuple(n for n in statement.graph.input_names if n not in assigned)
    shared = RingArithmetic(case, names, method.fixed, method.spare)

    def run(ask: Ask) -> bool:
        """True if goals and hypotheses hold: a case lies inside the statement's assumptions."""
        shared.ask = ask
        values = Walk(statement.graph, shared, ask).outputs()
        goals = zip(statement.goal_kinds, values, strict=False)
        given = zip(statement.given_kinds, values[len(statement.goal_kinds) :], strict=True)
        return all(_holds(shared, kind, v, method.log_lemma) for kind, v in (*goals, *given))

    try:
        return all(result for _, result in paths(run))
    except UndecidedError:
        return False


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


def _violation(statement: Statement, cases: list[Case]) -> Point | None:
    names = statement.graph.input_names
    points = (case.sample(names, shift) for case in cases for shift in range(SAMPLES))
    return first_violation(statement, points)


def _witnesses(statement: Statement, method: Ring) -> Iterator[Point]:
    """Points that satisfy the hypotheses (and, as a check of the algebra, the goals)."""
    for case in method.cases:
        point = case.sample(statement.graph.input_names, 0)
        given, goal = judge(statement, point)
        if given and not goal and not method.fixed:
            raise AssertionError(f"algebra and exact evaluation disagree at {point}")
        if given:
            yield point


def at_least_by_lemma(algebra: Algebra, value: Any, strict: bool) -> bool:
    """True if ln R >= 1 - 1/R shows that value = P + q ln R, with q > 0, is at least (above) 0."""
    bottom = algebra.sign(algebra.field(value.denom))
    if bottom not in ("+", "-"):
        return False
    split = _split(algebra, algebra.field(value.numer) * (1 if bottom == "+" else -1))
    if split is None:
        return False
    rest, factor, powers = split
    if algebra.sign(factor) == "-":
        factor, powers = -factor, {argument: -n for argument, n in powers.items()}
    if algebra.sign(factor) not in ("+", "+0"):
        return False
    ratio = algebra.field(1)
    for argument, n in powers.items():
        ratio = ratio * argument**n
    return algebra.sign(rest + factor * (1 - 1 / ratio)) in (("+",) if strict else ("+", "+0", "0"))


def _split(algebra: Algebra, value: Any) -> tuple[Any, Any, dict[Any, int]] | None:
    """(P, q, {argument: n}) with value = P + q sum n ln(argument), n integer; else None."""
    logs = {
        k: argument for k, (function, argument) in algebra.arguments.items() if function == "log"
    }
    rest: dict[Exponents, Any] = {}
    parts: dict[int, dict[Exponents, Any]] = {}
    for monomial, coefficient in value.numer.terms():
        present = [k for k in logs if monomial[k]]
        if len(present) > 1 or (present and monomial[present[0]] > 1):
            return None
        target = list(monomial)
        if not present:
            rest[monomial] = coefficient
            continue
        target[present[0]] = 0
        part = parts.setdefault(present[0], {})
        part[tuple(target)] = coefficient
    if not parts:
        return None

    def scaled(terms: dict[Exponents, Any]) -> Quotient:
        return algebra.field.over(algebra.field.polynomial(terms), value.denom)

    found = _common({logs[k]: scaled(part) for k, part in parts.items()})
    return None if found is None else (scaled(rest), *found)


def _common(parts: dict[Any, Any]) -> tuple[Any, dict[Any, int]] | None:
    base = next(iter(parts.values()))
    ratios = {argument: part / base for argument, part in parts.items()}
    exact = {k: ratio.number for k, ratio in ratios.items() if ratio.number is not None}
    if len(exact) < len(ratios):
        return None
    whole = lcm(*(int(number.denominator) for number in exact.values()))
    return base / whole, {argument: int(number * whole) for argument, number in exact.items()}
