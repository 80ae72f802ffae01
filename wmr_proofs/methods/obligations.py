"""Queries behind a verdict of z3, as SMT-LIB 2 text for any other solver."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import z3

from wmr_ctrl.results.ledger import REFUTED, Entry
from wmr_proofs.statement import Statement, own_point

from .point import judged
from .printed import printed
from .smt import Problem, posed


@dataclass(frozen=True)
class Obligation:
    """One query: a name, its text in SMT-LIB 2, and the expected answer."""

    name: str
    text: str
    wanted: str

    def file(self, key: str) -> str:
        """The exported text for the entry ``key``, with the expected answer."""
        head = f"; {key}, {self.name}: expected {self.wanted}"
        return f"{head}\n(set-info :status {self.wanted})\n{self.text}"


def of_entry(statement: Statement, entry: Entry) -> Iterator[Obligation]:
    """Obligations of a claim with a known verdict.

    Those of a refuted claim are the goals that its counterexample violates, and its hypotheses:
    both are expected to be satisfiable.  A refuted claim in several parts has none.
    """
    every = obligations(statement)
    if statement.parts and entry.verdict == REFUTED:
        return
    if entry.verdict != REFUTED:
        yield from every
        return
    point = {
        name: value if value.endswith("pi") else Fraction(value)
        for name, value in (entry.counterexample or {}).items()
    }
    _, kept = judged(statement, point)
    broken = {f"goal-{number}" for number, holds in enumerate(kept, 1) if not holds}
    for item in every:
        if item.name in broken or item.wanted == "sat":
            yield replace(item, wanted="sat")


def obligations(
    statement: Statement, point: Mapping[str, str] | None = None
) -> Iterator[Obligation]:
    """Each goal and each domain, to be unsatisfiable; the hypotheses alone, to be satisfiable.

    The hypotheses are posed at ``point``, exact rationals as text, if one is given.  In the names
    of parts' obligations the part's name comes last.
    """
    for key, part in statement.parts.items():
        for item in obligations(part, own_point(point or {}, part, key)):
            yield replace(item, name=f"{item.name}-{key}")
    if statement.parts:
        return
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
    yield Obligation("hypotheses", _text(problem, *pinned), "sat")


def _text(problem: Problem, *terms: Any) -> str:
    return printed([*problem.base, *terms], problem.terms.inputs)
