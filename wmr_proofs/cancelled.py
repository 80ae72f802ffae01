"""Operations that CasADi cancels while it builds a graph, such as x (1/x), must be defined, too.

A claim is built a second time without simplification.  Each quotient, root and logarithm that its
goals read there but not in the compiled graph must be defined wherever the hypotheses hold. z3
decides that, whatever method proved the claim.  If the hypotheses are regions, z3 is given the
inputs, sums and differences that are positive in all of them.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import is_dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import combinations, product
from typing import Any

import casadi as ca
import z3
from z3 import z3util

from .claim import CLAIMED, Claim, Each
from .claims import forget
from .graph import ProvedGraph, UndecidedError
from .methods.obligations import Obligation
from .methods.portfolio import Portfolio
from .methods.printed import printed
from .methods.smt import Problem, posed
from .methods.spec import Z3, Ball, Method, Ring, described
from .regions import FREE, NONNEGATIVE, NONZERO, POSITIVE, Case
from .statement import Statement

SOON, AT_ONCE = Z3(effort=20), Z3(effort=2)
Signs = Mapping[str, int]
"""A sum of inputs, each with the sign 1 or -1."""
DECLARED = " as declared"
_KNOWN: dict[str, tuple[Signs, ...]] = {}
_SIGNS: dict[str, bool] = {}


def undefined(claim: Claim) -> tuple[int, str]:
    """Number of cancelled operations, and those that may be undefined (empty if none).

    Only for a proved claim.
    """
    assert claim.method is not None
    try:
        raw, gone = cancelled_operations(claim)
    except UndecidedError as error:
        return 0, str(error)
    if not gone:
        return 0, ""
    inputs, context = raw.terms.inputs, raw.terms.context
    known = [*raw.base, *_within(claim.method, inputs, context)]
    left = [term for term in gone if Portfolio(SOON).ask([*known, term]).word != "unsat"]
    if isinstance(claim.method, Ring):
        cases = claim.method.cases
        left = [term for term in left if not _never(term, raw.base, inputs, context, cases)]
    return len(gone), "; ".join(term.sexpr()[:200] for term in left)


def cancelled_operations(claim: Claim, simple: bool = True) -> tuple[Problem, list[Any]]:
    """The claim posed without simplification, and conditions under which cancelled operations are
    undefined.

    ``simple``: z3 simplifies these conditions, as `undefined` asks about them.  Raises
    UndecidedError if the claim cannot be posed.
    """
    assert claim.statement is not None
    plain = uncancelled(claim)
    kept = posed(claim.statement(CLAIMED), simple=simple)
    raw = posed(plain, derived_powers(plain.graph), simple)
    before = {z3.simplify(term).sexpr() for term in kept.undefined}
    terms = {(found := z3.simplify(term)).sexpr(): (found, term) for term in raw.undefined}
    return raw, [both[not simple] for text, both in terms.items() if text not in before]


def cancelled_obligations(claim: Claim) -> Iterator[Obligation]:
    """The obligation, as text, for each cancelled operation that must be defined."""
    raw, gone = cancelled_operations(claim, simple=False)
    for number, term in enumerate(gone, 1):
        text = printed([*raw.base, term], raw.terms.inputs)
        yield Obligation(f"cancelled-{number}", text, "unsat")


def uncancelled(claim: Claim) -> Statement:
    """The claim's statement on graphs that CasADi has not simplified."""
    assert claim.statement is not None
    with _nothing_simplified():
        call = claim.statement
        if isinstance(call, Each):
            call = replace(call, tables={key: _fresh(row) for key, row in call.tables.items()})
        elif isinstance(call, partial):
            call = partial(call.func, **_fresh(call.keywords))
        statement = call(CLAIMED)
        _ = statement.graph
    return statement


def _fresh(given: Mapping[str, Any]) -> dict[str, Any]:
    """Copies of a function's arguments without their cached results."""
    own = {n: x for n, x in given.items() if is_dataclass(x) and not isinstance(x, type)}
    return {**given, **{name: replace(value) for name, value in own.items()}}


@contextmanager
def _nothing_simplified() -> Iterator[None]:
    forget()
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(True)
        forget()


def derived_powers(graph: ProvedGraph) -> frozenset[int]:
    """Logarithms in the derivative of x^n, which are multiplied by 0 for a number n."""
    readers: dict[int, list[int]] = {}
    for k, node in enumerate(graph.nodes):
        for arg in node.args:
            readers.setdefault(arg, []).append(k)

    def is_derivative(reader: int, log: int) -> bool:
        if graph.nodes[reader].op != "mul":
            return False
        other = next((arg for arg in graph.nodes[reader].args if arg != log), log)
        power = graph.nodes[other]
        constant = power.op == "pow" and graph.nodes[power.args[1]].op == "const"
        return constant and power.args[0] == graph.nodes[log].args[0]

    logs = (k for k, node in enumerate(graph.nodes) if node.op == "log")
    return frozenset(k for k in logs if all(is_derivative(r, k) for r in readers.get(k, ())))


def _within(method: Method, inputs: Mapping[str, Any], context: Any) -> list[Any]:
    """Hypotheses that a method contains as regions or boxes, about these inputs."""
    if isinstance(method, Ball):
        sides = ((inputs[name], pair) for name, pair in method.box.items() if name in inputs)
        return [
            item
            for symbol, (low, high) in sides
            for item in (symbol >= _number(low, context), symbol <= _number(high, context))
        ]
    if not isinstance(method, Ring):
        return []
    signs = [item for item in positive_sums(method.cases) if set(item) <= set(inputs)]
    return [sum(sign * inputs[name] for name, sign in item.items()) > 0 for item in signs]


def _never(
    term: Any, base: Sequence[Any], inputs: Mapping[str, Any], context: Any, cases: Sequence[Case]
) -> bool:
    """True if the term is false in each of the regions, with the inputs given by their charts."""
    for case in cases:
        free = {name: z3.Real(f"{name} of the chart", context) for name in case.numbers}
        chart = {name: value if z3.is_expr(value) else _number(value, context)
                 for name, value in case.values(free).items()}  # fmt: skip
        put = [(inputs[name], value) for name, value in chart.items() if name in inputs]
        known = [_DOMAINS[domain](free[name]) for name, domain in case.numbers.items()]
        known += [_DOMAINS[d](inputs[n]) for n, d in case.declared.items() if n in inputs]
        here = [z3.simplify(z3.substitute(item, *put)) for item in (*base, term)]
        if Portfolio(SOON).ask([*known, *here]).word != "unsat":
            return False
    return True


def _number(value: Fraction, context: Any) -> Any:
    return z3.RealVal(str(Fraction(value)), context)


def positive_sums(cases: Sequence[Case]) -> tuple[Signs, ...]:
    """Inputs, and sums and differences of two, that are positive in each of the cases."""
    key = str(described(cases))
    if key not in _KNOWN:
        ones = {name: Fraction(1) for case in cases for name in case.numbers}
        names = sorted({name for case in cases for name in (*case.values(ones), *case.declared)})
        single = [{name: sign} for name in names for sign in (1, -1)]
        known = [item for item in single if _positive(item, cases)]
        pairs = [
            {x: a, y: b}
            for x, y in combinations(names, 2)
            for a, b in product((1, -1), repeat=2)
            if {x: a} not in known or {y: b} not in known
        ]
        _KNOWN[key] = (*known, *(item for item in pairs if _positive(item, cases)))
    return _KNOWN[key]


def _positive(signs: Signs, cases: Sequence[Case]) -> bool:
    """True if the sum is proved positive in each case; points of the cases are tested first."""
    points = (case.sample(tuple(signs), shift) for case in cases for shift in range(3))
    if any(sum(sign * point[name] for name, sign in signs.items()) <= 0 for point in points):
        return False
    return all(_positive_in(signs, case) for case in cases)


def _positive_in(signs: Signs, case: Case) -> bool:
    context = z3.Context()
    free = {name: z3.Real(name, context) for name in case.numbers}
    own = {name: z3.Real(name + DECLARED, context) for name in case.declared}
    values = own | case.values(free)
    if not set(signs) <= set(values):
        return False
    total = sum(sign * values[name] for name, sign in signs.items())
    if not z3.is_expr(total):
        return bool(total > 0)
    total, domains = z3.simplify(total), case.declared | case.numbers
    read = [(symbol, str(symbol).removesuffix(DECLARED)) for symbol in z3util.get_vars(total)]
    key = f"{total.sexpr()} {[(name, domains[name]) for _, name in read]}"
    if key not in _SIGNS:  # many regions have the same chart of these inputs
        known = [_DOMAINS[domains[name]](symbol) for symbol, name in read]
        _SIGNS[key] = Portfolio(AT_ONCE).ask([*known, z3.Not(total > 0)]).word == "unsat"
    return _SIGNS[key]


_DOMAINS = {
    POSITIVE: lambda x: x > 0,
    NONNEGATIVE: lambda x: x >= 0,
    NONZERO: lambda x: x != 0,
    FREE: lambda x: x == x,
}
