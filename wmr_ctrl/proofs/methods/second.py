"""A second solver: what z3 closes, as SMT-LIB 2 text, checked again by cvc5."""

import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import chain
from typing import Any

import z3

from wmr_ctrl.proofs.methods.smt import Problem, posed
from wmr_ctrl.proofs.methods.spec import Z3, Both, Method
from wmr_ctrl.proofs.statement import Statement

NAME = "cvc5"
IMPATIENCE, PATIENCE = 2, 10
"""Seconds of the processor's time for one obligation and strategy, at first and in the end, so that
a busy machine finds the same."""
COVERINGS = {"nl-cov": "true", "nl-ext": "none"}
STRATEGIES: Mapping[str, Mapping[str, str]] = {
    "as it comes": {},
    "coverings": COVERINGS,
    "coverings, justified": {**COVERINGS, "decision": "justification"},
    "coverings, equalities split": {**COVERINGS, "arith-rewrite-equalities": "true"},
}
"""cvc5's ways with products of unknowns, one after the other: linear lemmas by default, and cells
that cover the space (cylindrical algebraic coverings), whose luck hangs on what comes first."""
LONGEST = 300.0
"""Seconds for one obligation by the clock, whatever the processor does meanwhile."""


@dataclass(frozen=True)
class Obligation:
    """One query: a name, its text in SMT-LIB 2, and the answer that the claim needs."""

    name: str
    text: str
    wanted: str


def obligations(
    statement: Statement, point: Mapping[str, str] | None = None
) -> Iterator[Obligation]:
    """Each goal and each domain, to be unsatisfiable; the hypotheses alone, to be satisfiable.

    Those are asked at ``point``, exact rationals as text, if one is given.
    """
    problem = posed(statement)
    for kind, terms in (("goal", problem.wrong), ("domain", problem.undefined)):
        for number, term in enumerate(terms, 1):
            yield Obligation(f"{kind}-{number}", _text(problem, term), "unsat")
    inputs, context = problem.terms.inputs, problem.terms.context
    pinned = [
        inputs[name] == z3.RealVal(value, context)
        for name, value in (point or {}).items()
        if name in inputs and not value.endswith("pi")
    ]
    here = z3.And(z3.BoolVal(True, context), *pinned)
    yield Obligation("hypotheses", _text(problem, here), "sat")


def _text(problem: Problem, term: Any) -> str:
    solver = z3.Solver(ctx=problem.terms.context)
    solver.add(*problem.base, term)
    return f"(set-logic QF_NRA)\n{solver.to_smt2()}"


def uses_z3(method: Method | None) -> bool:
    """True if a verdict of this method rests on z3."""
    return isinstance(method, Z3) or (
        isinstance(method, Both) and (uses_z3(method.first) or uses_z3(method.second))
    )


def confirmed_by(
    statement: Statement, point: Mapping[str, str] | None = None, patience: int = PATIENCE
) -> tuple[str, ...]:
    """``("cvc5",)`` where it finds every goal and every domain unsatisfiable, too, else nothing.

    And the hypotheses satisfiable, at ``point`` if one is given.
    """
    if find_spec(NAME) is None:
        return ()
    every = obligations(statement, point)
    return (NAME,) if all(answer(o.text, patience) == o.wanted for o in every) else ()


def answer(text: str, patience: int = PATIENCE) -> str:
    """Answer of cvc5 to a file: sat, unsat or unknown; each strategy soon, then with patience."""
    limits = [limit for limit in (IMPATIENCE, patience) if limit <= patience]
    said = (_said(text, limit, way) for limit in limits for way in STRATEGIES.values())
    return next((word for word in said if word in ("sat", "unsat")), "unknown")


def _said(text: str, patience: int, options: Mapping[str, str]) -> str:
    """In a process of its own, which can be ended: it does not always keep to its own limits."""
    command = [sys.executable, "-c", _ASK, str(patience), *chain(*options.items())]
    try:
        done = subprocess.run(
            command, input=text, capture_output=True, text=True, timeout=LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        return "unknown"
    return done.stdout.strip() or "unknown"


_ASK = """
import sys, cvc5
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CPU, (int(sys.argv[1]), int(sys.argv[1])))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:  # Windows: LONGEST alone bounds it
    pass
solver = cvc5.Solver(cvc5.TermManager())
for name, value in zip(sys.argv[2::2], sys.argv[3::2]):
    solver.setOption(name, value)
parser = cvc5.InputParser(solver)
parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, sys.stdin.read(), "obligation")
symbols = parser.getSymbolManager()
while not (command := parser.nextCommand()).isNull():
    sys.stdout.write(command.invoke(solver, symbols))
"""
