"""Find certificates for `wmr_proofs.check` by z3 and flint: ``python -m wmr_proofs.find ID``.

Nothing here is trusted.  A model of z3 shows which choice it violates, and that choice is split.
If z3 says that the facts of a case contradict each other, a small subset that does so is searched.
Linear programming then finds products of these facts that add up to 0 (`wmr_proofs.products`).  If
a case does not need its own condition, its tree also closes the other cases.
``python -m tests.proofs.record ID`` then enters the results in the ledger.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from itertools import islice
from math import prod
from time import process_time
from typing import Any, TypeAlias

import z3
from flint import Ordering, fmpq, fmpq_mpoly_ctx

from wmr_ctrl.results.ledger import REFUTED, Entry, load

from .certificates import FOLDER, obligations_of, save, words_hash
from .check import (
    WORK,
    Case,
    Choice,
    Fact,
    Formula,
    Join,
    Monomial,
    Number,
    Polynomial,
    Problem,
    Quotient,
    Refused,
    add,
    check,
    digest,
    exact,
    key,
    mul,
    names,
    negated,
    unpacked,
    var,
)
from .claim import Claim
from .claims import all_claims
from .methods.obligations import Obligation
from .methods.spec import Z3
from .products import (
    Facts,
    Products,
    Used,
    able_to_cancel,
    groups,
    multiples,
    product_of,
    products,
    quotient,
    shares,
)
from .runner import selected

Node: TypeAlias = list[Any]
"""Node of a tree, as in `check`."""

ROOT = "~"
"""Begins the name of a square in a search."""
SIGN = "cs"
"""Begins the name of a cut that shows the sign of an unknown in all cases."""
DEPTH = 150
"""Most cases within cases."""
CUTS = 3
"""Most cases of signs among them."""
EVERY = 8000
"""Most products that are tried."""
KEPT = 12
"""Most sums that are tried again."""
FORMULAS = 20_000
"""Most facts that are kept in the form for z3."""
SECONDS = 10.0
"""Processor time for one obligation [s]."""
SOON = 300_000
"""Work of z3 for a question about a few facts."""
LATER = 3_000_000
"""Work of z3 for a question about the facts of a case."""
RATE = 1000
"""Least work of z3 in a millisecond; z3 does not count all of its work."""


class NotFound(Exception):  # noqa: N818
    """No certificate was found by this search, or in time."""


def proof(text: str, seconds: float = SECONDS) -> Node:
    """A tree that refutes an obligation; raises NotFound if none is found in time."""
    WORK.left = 10**15
    problem = Problem(text)
    return Search(process_time() + seconds).tree(Case(problem, problem.facts, {}, {}))


def point(text: str, known: Mapping[str, str]) -> dict[str, str]:
    """Rational numbers for all symbols at which an obligation holds, including ``known`` ones if
    possible.
    """
    symbols, asserted = Problem(text).symbols, z3.parse_smt2_string(text)
    given = [_real(name) == z3.RealVal(value) for name, value in known.items()
             if f"|{name}|" in symbols and not value.endswith("pi")]  # fmt: skip
    for more in (given, []):
        for name in ("smt", "qfnra-nlsat"):
            solver = z3.Tactic(name).solver()
            solver.set("rlimit", LATER)
            solver.add(*asserted, *more)
            if solver.check() != z3.sat:
                continue
            values = {name: solver.model().eval(_real(name), True) for name in symbols}
            if all(map(z3.is_rational_value, values.values())):
                return {name: str(value.as_fraction()) for name, value in values.items()}
    raise NotFound("no point of rational numbers")


def _real(name: str) -> Any:
    return z3.Real(name.strip("|"))


class Search:
    """A search with a time limit."""

    def __init__(self, end: float) -> None:
        self.end = end
        self.good: list[list[Used]] = []
        """Products of sums that were found, the latest first."""

    def tree(self, case: Case, depth: int = 0) -> Node:
        """A tree that refutes a case."""
        if depth > DEPTH:
            raise NotFound("too many cases within cases")
        heads = []
        for head, inner in self._signs(case, depth == 0):
            heads.append((case, head))
            case = inner
        facts = _facts(case)
        node, model = self._end(facts, LATER)
        node = node or self._split(case, facts, model, depth)
        for outer, head in reversed(heads):
            if not _refutes(outer, node):
                node = [*head, node]
        return node

    def _end(self, facts: Facts, work: int) -> tuple[Node | None, Any]:
        """A sum which shows that facts contradict each other, and z3's model if they do not."""
        found = self._sum(facts, 1)
        unequal = {name for name, fact in facts.items() if fact.kind != "="}
        for uses in self.good:
            if found is None and unequal >= set().union(*uses):
                found = self._total(facts, uses, 2)
        if found is not None:
            return found, None
        answer, model = self._asked(facts.values(), work)
        return self._closed(facts) if answer == z3.unsat else None, model

    def _closed(self, facts: Facts) -> Node | None:
        """A sum of facts that z3 finds to contradict each other."""
        few = self._core(facts)
        unknowns = set[str]().union(*(names(fact.poly) for fact in few.values()))
        near = {name: fact for name, fact in facts.items()
                if len(names(fact.poly)) == 1 and names(fact.poly) <= unknowns}  # fmt: skip
        signed = near | few
        found = self._sum(few, 2)
        left = groups(signed, few)
        while found is None and (group := next(left, None)):
            found = self._total(signed, group, 2)
        found = found or self._sum(signed | _squares(few), 2)
        if found is not None:
            self.good.insert(0, [tuple(item[1]) for item in found[1]])
            del self.good[KEPT:]
        return found

    def _core(self, facts: Facts) -> Facts:
        """A small subset of the facts that still contradict each other."""
        solver = z3.SimpleSolver()
        solver.set(rlimit=SOON, timeout=SOON // RATE)
        for name, fact in facts.items():
            solver.assert_and_track(_formula(fact), name)
        contradicted = solver.check() == z3.unsat
        kept = [mark.decl().name() for mark in solver.unsat_core()] if contradicted else list(facts)
        for name in tuple(kept):
            less = [other for other in kept if other != name]
            if self._asked([facts[other] for other in less], SOON)[0] == z3.unsat:
                kept = less
        return {name: facts[name] for name in kept}

    def _signs(self, case: Case, first: bool) -> Iterator[tuple[Node, Case]]:
        """Cases with one known sign more, after the node that shows it: of a denominator, and
        ``first`` of unknowns.
        """
        facts = _facts(case)
        for unknown in case.problem.symbols if first else ():
            if Fact(var(unknown), ">") in facts.values():
                continue
            for sign in (1, -1):
                name, wrong = f"{SIGN}{len(facts)}", Fact(add({}, var(unknown), -sign), ">=")
                total = self._sum({**facts, name: wrong}, 1)
                if total is not None:
                    case = case.having(name, negated(wrong))
                    facts = _facts(case)
                    yield ["cut", name, _told(wrong.poly), total], case
                    break
        for number, atom in enumerate(case.problem.atoms):
            if not isinstance(atom, Quotient) or key(atom.below) in case.signs:
                continue
            below = case.plain(atom.below)
            if any(name.startswith("?") for name in names(below)):
                continue
            for sign in (1, -1):
                wrong = Fact(add({}, below, -sign), ">=")
                total, _ = self._end({**facts, "*": wrong}, SOON)
                if total is not None:
                    case = case.signed(number, sign)
                    facts = _facts(case)
                    yield ["den", number, sign, total], case
                    break

    def _split(self, case: Case, facts: Facts, model: Any, depth: int) -> Node:
        """The cases of a choice, or of a disjunction, which a model violates if there is one."""
        atoms = case.problem.atoms
        read = {name for fact in facts.values() for name in names(fact.poly)}

        def holds(formula: Formula) -> bool:
            return z3.is_true(model.eval(_formula(_plain(case, formula)), model_completion=True))

        choices = [(number, atom) for number, atom in enumerate(atoms)
                   if isinstance(atom, Choice) and number not in case.chosen]  # fmt: skip
        broken = [name for name, formula in case.facts.items() if isinstance(formula, Join)
                  and not any(other.startswith(f"{name}:") for other in case.facts)
                  and (model is None or not holds(formula))]  # fmt: skip
        if model is not None:
            taken = ((c.yes if holds(c.condition) else c.no) for _, c in choices)
            choices = [pair for pair, value in zip(choices, taken, strict=True)
                       if not holds(Fact(add(var(f"?{pair[0]}"), value, -1), "="))]  # fmt: skip
        ready = [number for number, choice in choices if not _waits(case, choice.condition)]
        if model is None:
            ready = [number for number in ready if f"?{number}" in read] or ready
        if broken and (model is not None or not ready):
            name = broken[0]
            parts = case.facts[name].parts  # type: ignore[union-attr]
            cases = [case.having(f"{name}:{k}", part) for k, part in enumerate(parts)]
            return self._cases(["or", name], case, cases, depth)
        if not choices:
            return self._by_sign(case, facts, depth)
        number = ready[-1] if ready else choices[0][0]
        return self._cases(
            ["ite", number], case, [case.taking(number, yes) for yes in (True, False)], depth
        )

    def _by_sign(self, case: Case, facts: Facts, depth: int) -> Node:
        """The cases of a sign: of a factor of contradictory facts, or of an unknown."""
        core = self._core(facts).values()
        chosen = [fact for name, fact in facts.items() if name[-1] in "+-"]
        read = [factor for fact in (*core, *chosen) for factor in _factors(fact.poly)]
        read += [var(name) for fact in core for name in sorted(names(fact.poly))]
        cuts = sum(1 for name in facts if name.startswith("c") and not name.startswith(SIGN))
        free = (p for p in read if cuts < CUTS and all(
            self._sum({**facts, "*": Fact(add({}, p, sign), ">")}, 1) is None for sign in (1, -1)
        ))  # fmt: skip
        poly = next(free, None)
        if poly is None:
            raise NotFound("no case is left to be split")
        name, cut = f"c{cuts}", Fact(poly, ">=")
        cases = [case.having(name, cut), case.having(name, negated(cut))]
        return self._cases(["cut", name, _told(cut.poly)], case, cases, depth)

    def _cases(self, head: Node, case: Case, cases: Iterable[Case], depth: int) -> Node:
        for part in cases:
            node = self.tree(part, depth + 1)
            if _refutes(case, node):
                return node
            head.append(node)
        return head

    def _asked(self, facts: Iterable[Fact], work: int) -> tuple[Any, Any]:
        """z3's answer and model."""
        if process_time() > self.end:
            raise NotFound("out of time")
        for name in ("qfnra-nlsat", "smt"):
            solver = z3.Tactic(name).solver()
            solver.set(rlimit=work, timeout=work // RATE)
            solver.add(*map(_formula, facts))
            answer = solver.check()
            if answer != z3.unknown:
                return answer, solver.model() if answer == z3.sat else None
        return z3.unknown, None

    def _sum(self, facts: Facts, most: int) -> Node | None:
        """A sum of products of at most ``most`` facts and of multiples of equations."""
        return self._total(facts, products(facts, most), 1)

    def _total(self, facts: Facts, uses: Iterable[Used], rounds: int) -> Node | None:
        """A sum of these products and of multiples of equations."""
        if process_time() > self.end:
            raise NotFound("out of time")
        known = Products()
        found = {used: product_of(facts, used, known) for used in islice(uses, EVERY)}
        free = multiples(facts, found, rounds)
        if len(found) + len(free) > EVERY:
            return None
        found = able_to_cancel(found, free)
        above = {used: strict for used, (_, strict) in found.items()}
        if not any(above.values()):
            return None
        value = shares({used: p for used, (p, _) in found.items()} | free, above)
        if value is None:
            return None
        equations = dict[Any, Polynomial]()
        for used in value.keys() - above.keys():
            equations.setdefault(used[0], {})[used[1]] = value[used]
        told = [[name, _told(p)] for name, p in equations.items() if any(p.values())]
        items = [_item(value[used], used) for used in above if value.get(used)]
        return ["sum", items, told]


def _facts(case: Case) -> Facts:
    return {name: case.fact(name) for name, formula in case.facts.items()
            if isinstance(formula, Fact)}  # fmt: skip


def _refutes(case: Case, node: Node) -> bool:
    try:
        case.refuted(node)
    except Refused:
        return False
    return True


def _plain(case: Case, formula: Formula) -> Formula:
    if isinstance(formula, Fact):
        return Fact(case.plain(formula.poly), formula.kind)
    return Join(formula.word, tuple(_plain(case, part) for part in formula.parts))


def _waits(case: Case, condition: Formula) -> bool:
    """True if a condition reads choices that are undecided."""
    if isinstance(condition, Join):
        return any(_waits(case, part) for part in condition.parts)
    left = (int(name[1:]) for name in names(case.plain(condition.poly)) if name.startswith("?"))
    return any(isinstance(case.problem.atoms[number], Choice) for number in left)


def _formula(formula: Formula) -> Any:
    """A formula for z3."""
    if isinstance(formula, Join):
        parts = [_formula(part) for part in formula.parts]
        return z3.And(*parts) if formula.word == "and" else z3.Or(*parts)
    return _compared(key(formula.poly), formula.kind)


@lru_cache(FORMULAS)
def _compared(poly: tuple[tuple[Monomial, Number], ...], kind: str) -> Any:
    """A fact for z3."""
    terms = [
        prod([_real(name) ** power if power > 1 else _real(name) for name, power in monomial],
             start=z3.RealVal(str(c)))
        for monomial, c in poly
    ]  # fmt: skip
    value = z3.Sum([z3.RealVal(0), *terms])
    return {"=": value == 0, ">": value > 0, ">=": value >= 0}[kind]


def _squares(facts: Facts) -> Facts:
    """Candidate squares for completing a fact; their roots are in their names."""
    roots = [_derivative(p, name) for p, _ in facts.values() for name in names(p)
             if max(dict(m).get(name, 0) for m in p) == 2]  # fmt: skip
    told = (f"{ROOT}{json.dumps(_told(root))}" for root in roots)
    return {name: Fact(mul(root, root), ">=") for name, root in zip(told, roots, strict=True)}


def _derivative(p: Polynomial, name: str) -> Polynomial:
    return {rest: c * dict(m)[name] for m, c in p.items()
            if (rest := quotient(m, ((name, 1),))) is not None}  # fmt: skip


def _factors(p: Polynomial) -> list[Polynomial]:
    """Factors, with their own coefficients, of a polynomial that has several."""
    unknowns = sorted(names(p)) or ["x"]
    ring = fmpq_mpoly_ctx.get(unknowns, Ordering.lex)
    terms = {tuple(dict(m).get(name, 0) for name in unknowns): fmpq(str(c)) for m, c in p.items()}
    _, found = ring.from_dict(terms).factor()
    if len(found) < 2:
        return []
    return [
        {tuple((n, int(e)) for n, e in zip(unknowns, powers, strict=True) if e): exact(str(c))
         for powers, c in factor.to_dict().items()}
        for factor, _ in found
    ]  # fmt: skip


def _item(share: object, used: Used) -> Node:
    """A product in the form of a certificate."""
    roots = [json.loads(name[1:]) for name in used if name.startswith(ROOT)]
    facts = [name for name in used if not name.startswith(ROOT)]
    return [str(share), facts, roots] if roots else [str(share), facts]


def _told(p: Polynomial) -> Node:
    """A polynomial in the form of a certificate."""
    return [[str(c), *(x for pair in m for x in pair)] for m, c in sorted(p.items()) if c]


@cache
def committed() -> dict[str, Any]:
    """Every certificate by its obligation's text without the lines that name it."""
    files = FOLDER.glob("*.json.xz")
    pairs = (pair for path in files for pair in unpacked(path).values())
    return {text.split("\n", 2)[2]: certificate for text, certificate in pairs}


def find(claim: Claim, entry: Entry, seconds: float) -> dict[str, Any]:
    """Certify the obligations of an entry if possible, save them, and return its row of the index.

    A committed certificate that shows an obligation of the present is kept, whatever its name was.
    """
    kept = committed()
    rows, found = [], {}
    for item in obligations_of(claim, entry):
        text = item.file(claim.id)
        certificate = _certificate(text, item, kept.get(item.text), entry, seconds)
        if certificate is not None:
            found[item.name] = [text, certificate]
        shown = digest(certificate) if certificate is not None else ""
        rows.append([item.name, item.wanted, digest(text), shown])
    row = {
        "id": claim.id,
        "verdict": entry.verdict,
        "claim": words_hash(claim),
        "obligations": rows,
    }
    save(row, found)
    return row


def _certificate(
    text: str, item: Obligation, known: Any, entry: Entry, seconds: float
) -> dict[str, Any] | None:
    """The known certificate if it is valid, else a new one; None if none is found."""
    try:
        if check(text, known) == item.wanted:
            return known
    except Refused:
        pass
    at = entry.counterexample if entry.verdict == REFUTED else entry.satisfied_at
    try:
        unsat = item.wanted == "unsat"
        found = {"proof": proof(text, seconds)} if unsat else {"point": point(text, at or {})}
        return found if check(text, found) == item.wanted else None
    except (NotFound, Refused) as error:
        sys.stderr.write(f"{entry.id}, {item.name}: {error}\n")
        return None


def main(arguments: Sequence[str] | None = None) -> None:
    """Find certificates of the named entries, and save them."""
    parser = argparse.ArgumentParser(prog="python -m wmr_proofs.find", description=__doc__)
    parser.add_argument("ids", nargs="*", metavar="ID", help="entries, or globs of them; none: all")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of the processor, for each")
    given = parser.parse_args(arguments)
    wanted, entries = set(selected(given.ids)), load().by_id()
    for claim in all_claims():
        if claim.id in wanted & set(entries) and isinstance(claim.method, Z3):
            rows = find(claim, entries[claim.id], given.seconds)["obligations"]
            shown = sum(1 for item in rows if item[3])
            sys.stdout.write(f"{claim.id}: {shown} of {len(rows)}\n")


if __name__ == "__main__":
    main()
