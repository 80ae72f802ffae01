"""Z3: the graph as terms over the reals; roots and sines by their relations, others opaque.

A goal is meaningful only if its operations are defined: a quotient needs a denominator that is not
0, a logarithm a positive argument, a root an argument that is not negative.  This is required where
the goal reads them; the branch of a choice that is not taken needs nothing.
"""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce
from itertools import chain
from math import atan2
from operator import mul
from typing import Any

import z3

from wmr_ctrl.results.ledger import OPEN, PROVED, REFUTED
from wmr_proofs.graph import ARITHMETIC, COMPARE, Arithmetic, Ask, UndecidedError, Walk
from wmr_proofs.statement import ABOVE, EQUAL, Statement, behind, own_name

from .point import first_violation, judge
from .portfolio import Answer, Portfolio
from .spec import Z3, Finding, Point

WORK = "work"
"""Key of the evidence: millions of units that z3 spent on the statement, see `portfolio`."""
ENGINES_USED = "engines"


class TermArithmetic(Arithmetic):
    """z3 terms; ``facts`` collects known relations of roots, sines and exponentials.

    They are in a separate context: z3 orders terms by their number, so in a shared one its results
    and times would depend on all earlier questions.
    """

    def __init__(self) -> None:
        self.context = z3.Context()
        self.inputs: dict[str, Any] = {}
        self.facts: list[Any] = []
        self.atoms: dict[tuple[str, Any], Any] = {}
        self.inverses: dict[int, tuple[Any, Any]] = {}

    def constant(self, value: float) -> Any:
        """The double, exactly."""
        exact = Fraction(value)
        return z3.RealVal(f"{exact.numerator}/{exact.denominator}", self.context)

    def variable(self, name: str) -> Any:
        """One real variable per input."""
        return self.inputs.setdefault(name, z3.Real(name, self.context))

    def apply(self, op: str, args: list[Any]) -> Any:
        """Term of an operation."""
        call = _OPERATIONS.get(op) or getattr(self, f"_{op}", None)
        if call is None:
            raise UndecidedError(f"no term for {op} is known")
        return call(*args)

    def compare(self, op: str, left: Any, right: Any, _ask: Ask) -> Any:
        """Term of a comparison."""
        return COMPARE[op](left, right)

    def logic(self, op: str, args: list[Any]) -> Any:
        """Term of a connective."""
        return z3.Not(args[0]) if op == "not" else (z3.And(*args) if op == "and" else z3.Or(*args))

    def merge(self, condition: Any, yes: Any, no: Any) -> Any:
        """If-then-else."""
        return z3.If(condition if z3.is_bool(condition) else condition != 0, yes, no)

    def number(self, condition: Any) -> Any:
        """1 or 0."""
        return z3.If(condition, self.constant(1), self.constant(0))

    def _inv(self, a: Any) -> Any:
        term = 1 / a
        self.inverses[term.get_id()] = (term, a)
        return term

    def _mul(self, a: Any, b: Any) -> Any:
        """A product with an inverse as a quotient, which solvers handle better."""
        for one, other in ((a, b), (b, a)):
            if other.get_id() in self.inverses:
                return one / self.inverses[other.get_id()][1]
        return a * b

    def _sqrt(self, a: Any) -> Any:
        root = self._atom("sqrt", a)
        self.facts.append(z3.Implies(a >= 0, z3.And(root >= 0, root * root == a)))
        return root

    def _sign(self, a: Any) -> Any:
        up, level, down = map(self.constant, (1, 0, -1))
        return z3.If(a > 0, up, z3.If(a < 0, down, level))

    def _sin(self, a: Any) -> Any:
        return self._pair(a)[0]

    def _cos(self, a: Any) -> Any:
        return self._pair(a)[1]

    def _pair(self, a: Any) -> tuple[Any, Any]:
        s, c = self._atom("sin", a), self._atom("cos", a)
        self.facts.append(s * s + c * c == 1)
        return s, c

    def _log(self, a: Any) -> Any:
        return self._atom("log", a)

    def _tanh(self, a: Any) -> Any:
        found = self._atom("tanh", a)
        known = (a > 0, found > 0), (a < 0, found < 0)
        self.facts.extend([found < 1, found > -1, *(one == other for one, other in known)])
        return found

    def _exp(self, a: Any) -> Any:
        found = self._atom("exp", a)
        self.facts.append(found > 0)
        return found

    def _expm1(self, a: Any) -> Any:
        found = self._atom("expm1", a)
        self.facts.extend([found > -1, (a > 0) == (found > 0), (a < 0) == (found < 0)])
        return found

    def _atom(self, function: str, a: Any) -> Any:
        term = z3.simplify(a)
        return self.atoms.setdefault(
            (function, term.sexpr()), z3.Real(f"{function} of {len(self.atoms)}", self.context)
        )

    def angles(self) -> Mapping[str, tuple[Any, Any]]:
        """(sine, cosine) of every input that is directly used as an angle."""
        return {
            name: (self.atoms["sin", name], self.atoms["cos", name])
            for name in self.inputs
            if ("sin", name) in self.atoms and ("cos", name) in self.atoms
        }


_OPERATIONS: dict[str, Callable[..., Any]] = {
    **{name: call for name, call in ARITHMETIC.items() if name not in ("mul", "inv")},
    "fabs": lambda a: z3.If(a >= 0, a, -a),
    "fmin": lambda a, b: z3.If(a <= b, a, b),
    "fmax": lambda a, b: z3.If(a >= b, a, b),
    **dict.fromkeys(("constpow", "pow"), lambda a, b: _power(a, b)),
}


def _power(a: Any, b: Any) -> Any:
    """An integer power as a product, since SMT-LIB has no other."""
    whole = z3.is_rational_value(b) and b.denominator_as_long() == 1
    times = b.numerator_as_long() if whole else -1
    if times < 0:
        raise UndecidedError(f"no term for the power {b} is known")
    return reduce(mul, [a] * times) if times else 1 + 0 * a


def decide(statement: Statement, method: Z3) -> Finding:
    """PROVED if no goal can fail or be undefined and the hypotheses can be satisfied.

    REFUTED by an exact point.  Each part of a statement with parts is decided separately.
    """
    if statement.parts:
        return _in_parts(statement, method)
    known = _fitting(statement, method.points)
    found = first_violation(statement, known)
    if found is not None:
        return Finding(REFUTED, {"points tried": len(known)}, found)
    try:
        problem = posed(statement)
    except UndecidedError as error:
        return Finding(OPEN, {"not posed": str(error)})
    answers, engines = list[Answer](), Portfolio(method)
    for place, wrong in enumerate(problem.wrong):
        terms = [*problem.base, wrong]
        answers.append(engines.ask(terms, place))
        found = _broken_at(statement, problem, terms, answers[-1].model, engines)
        if found is None and answers[-1].word == "sat":  # perhaps where an operation is undefined
            defined = [*terms, *map(z3.Not, problem.undefined)]
            model = engines.ask(defined, place).model
            found = _broken_at(statement, problem, defined, model, engines)
        if found is not None:
            return Finding(REFUTED, _evidence(answers, engines), found)
    if {answer.word for answer in answers} <= {"unsat"}:
        return _unless_undefined_or_vacuous(statement, problem, engines, answers)
    return Finding(OPEN, _evidence(answers, engines) | _effort(engines))


def _in_parts(statement: Statement, method: Z3) -> Finding:
    """The verdict on all parts, with the first counterexample, or a point that meets all."""
    found, spent, point = list[Finding](), 0.0, dict[str, Fraction]()
    flat = all(isinstance(names, str) for names in method.first)
    for k, (key, part) in enumerate(statement.parts.items()):
        first = method.first if flat else tuple(chain(*method.first[k : k + 1]))
        one = decide(part, replace(method, effort=method.effort - spent, first=first))
        own = {own_name(name, key): value for name, value in (one.point or {}).items()}
        found.append(one)
        if one.verdict == REFUTED:
            return Finding(REFUTED, _all_evidence(found), own)
        spent += one.evidence.get(WORK, 0)
        point |= own
    met = all(one.point is not None for one in found)
    verdict = PROVED if {one.verdict for one in found} == {PROVED} else OPEN
    return Finding(verdict, _all_evidence(found), point if met else None)


def _all_evidence(found: Sequence[Finding]) -> dict[str, Any]:
    """Evidence of the first part that is not proved, or the last, with the sums of all numbers."""
    told = dict(next((one for one in found if one.verdict != PROVED), found[-1]).evidence)
    for key in (key for key, value in told.items() if not isinstance(value, str | list)):
        told[key] = round(sum(one.evidence.get(key, 0) for one in found), 1)
    return told | {ENGINES_USED: [one.evidence.get(ENGINES_USED, []) for one in found]}


def _fitting(statement: Statement, points: Sequence[Point]) -> list[Point]:
    """Points that have values for all inputs of the graph."""
    return [point for point in points if set(statement.graph.input_names) <= set(point)]


def _evidence(answers: Sequence[Answer], engines: Portfolio) -> dict[str, Any]:
    words = sorted({answer.word for answer in answers})
    known = {"queries": len(answers), "z3": " ".join(words), **_engines(answers)}
    return {**known, WORK: round(engines.spent, 1)}


def _effort(engines: Portfolio) -> dict[str, str]:
    """Cost of an open statement: engines that were called, and their total work."""
    spent = f"{engines.spent:.3g} of {engines.method.effort:g} million units"
    return {"tried": f"{', '.join(engines.tried)}: {spent} of z3's work"}


def _engines(answers: Sequence[Answer]) -> dict[str, list[str]]:
    """Engine for each question that the first engine did not answer."""
    names = [answer.engine for answer in answers]
    while names and not names[-1]:
        names.pop()
    return {ENGINES_USED: names} if names else {}


@dataclass(frozen=True)
class Problem:
    """A statement as terms: hypotheses, and the negation of each goal and domain."""

    terms: TermArithmetic
    base: list[Any]
    wrong: list[Any]
    undefined: list[Any]


def posed(statement: Statement, but: Container[int] = (), simple: bool = False) -> Problem:
    """The statement for a solver: it is true if ``base`` with each negated term is unsatisfiable.

    ``but``: nodes that may be undefined; ``simple``: z3 simplifies when operations are.
    """
    terms = TermArithmetic()
    walk = Walk(statement.graph, terms, lambda _: False)
    values = walk.outputs()
    goals = len(statement.goal_kinds)
    given = [relation(k, v) for k, v in zip(statement.given_kinds, values[goals:], strict=True)]
    wrong = [z3.Not(relation(k, v)) for k, v in zip(statement.goal_kinds, values, strict=False)]
    return Problem(terms, given + terms.facts, wrong, list(violations(walk, goals, but, simple)))


def _unless_undefined_or_vacuous(
    statement: Statement, problem: Problem, engines: Portfolio, answers: list[Answer]
) -> Finding:
    base, goals, domains = problem.base, len(answers), len(problem.undefined)
    known = {**_evidence(answers, engines), "domains": domains}
    for place, out in enumerate(problem.undefined, goals):
        answers.append(engines.ask([*base, out], place))
    words = {answer.word for answer in answers[goals:]}
    if not words <= {"unsat"}:
        return Finding(OPEN, {**known, "undefined": " ".join(sorted(words)), **_effort(engines)})
    answers.append(engines.ask(base, goals + domains))
    if answers[-1].word != "sat":
        return Finding(OPEN, {**known, "hypotheses": answers[-1].word, **_effort(engines)})
    met = _met(statement, problem.terms, base, answers[-1].model, engines)
    points = chain(_fitting(statement, engines.method.points), met)
    point = next((point for point in points if judge(statement, point)[0]), None)
    known |= {"hypotheses": "satisfiable", **_engines(answers), WORK: round(engines.spent, 1)}
    return Finding(PROVED, known, point)


def _broken_at(
    statement: Statement, problem: Problem, terms: list[Any], model: Any, engines: Portfolio
) -> Point | None:
    """The first exact counterexample among points from models."""
    return first_violation(statement, _met(statement, problem.terms, terms, model, engines))


def _met(
    statement: Statement,
    arithmetic: TermArithmetic,
    terms: list[Any],
    model: Any,
    engines: Portfolio,
) -> Iterator[Point]:
    """Points of a model, if there is one, then of each engine's: only some have rational values."""
    if model is None:
        return
    yield from _points(statement, arithmetic, model)
    for other in engines.other_models(terms):
        yield from _points(statement, arithmetic, other)


def relation(kind: str, value: Any) -> Any:
    """Term of a value compared with 0."""
    return value == 0 if kind == EQUAL else (value > 0 if kind == ABOVE else value >= 0)


def _points(statement: Statement, arithmetic: TermArithmetic, model: Any) -> Iterator[Point]:
    """A model as rational points; angles from their sine and cosine."""

    def rational(term: Any) -> Fraction:
        value = model.eval(term.translate(model.ctx), model_completion=True)
        return (value.approx(40) if z3.is_algebraic_value(value) else value).as_fraction()

    point = {name: rational(variable) for name, variable in arithmetic.inputs.items()}
    for name, (s, c) in arithmetic.angles().items():
        point[name] = Fraction(atan2(float(rational(s)), float(rational(c))))
    yield {name: point.get(name, Fraction(0)) for name in statement.graph.input_names}


OUTSIDE: dict[str, Callable[..., Any]] = {
    "div": lambda _, below: below == 0,
    "inv": lambda below: below == 0,
    "log": lambda a: a <= 0,
    "sqrt": lambda a: a < 0,
}
"""Condition under which an operation's result is not defined."""


def violations(
    walk: Walk, goals: int, but: Container[int] = (), simple: bool = False
) -> Iterator[Any]:
    """Terms, each true where one operation behind the first ``goals`` outputs is undefined.

    ``simple``: simplified by z3.
    """
    guards = _guards(walk, goals)
    for k, guard in guards.items():
        node = walk.graph.nodes[k]
        if node.op in OUTSIDE and k not in but:
            outside = OUTSIDE[node.op](*(walk.values[arg] for arg in node.args))
            if simple:
                outside = z3.simplify(outside)
            if not z3.is_false(z3.simplify(outside)):
                yield z3.And(guard, outside)


def _guards(walk: Walk, goals: int) -> dict[int, Any]:
    """Conditions under which each node that a goal needs is read."""
    guards: dict[int, Any] = {
        k: z3.BoolVal(True, walk.values[k].ctx) for k in walk.graph.outputs[:goals]
    }
    for k in range(len(walk.graph.nodes) - 1, -1, -1):
        if k not in guards:
            continue
        node = walk.graph.nodes[k]
        args = node.args if node.op != "input" else behind(walk.graph, k)
        conditions = [guards[k]] * len(args)
        if node.op == "choose":
            truth = walk.truth(args[0])
            conditions[1:] = z3.And(guards[k], truth), z3.And(guards[k], z3.Not(truth))
        for arg, condition in zip(args, conditions, strict=True):
            if arg not in guards:
                guards[arg] = condition
            elif not z3.is_true(guards[arg]):
                guards[arg] = condition if z3.is_true(condition) else z3.Or(guards[arg], condition)
    return guards
