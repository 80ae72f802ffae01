"""Find certificates for `wmr_proofs.check` by z3 and flint: ``python -m wmr_proofs.find ID``.

Nothing here is trusted.  A model of z3 shows which choice it violates, and that choice is split.
If z3 says that the facts of a case contradict each other, a small subset that does so is searched.
Exact linear programming then finds products of these facts that add up to 0.  If a case does not
need its own condition, its tree also closes the other cases.  ``python -m tests.proofs.record ID``
then enters the results in the ledger.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
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
    Polynomial,
    Problem,
    Quotient,
    Refused,
    add,
    check,
    const,
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
from .methods.obligations import Obligation, uses_z3
from .runner import selected

Facts: TypeAlias = dict[str, Fact]
Node: TypeAlias = list[Any]
"""Of a tree, as `check` has it."""
Used: TypeAlias = tuple[Any, ...]
"""Names of the facts in a product, or of an equation and the monomial of its multiple."""

ROOT = "~"
"""Begins the name of a square in a search."""
DEGREE = 5
"""Most factors of a product."""
DEPTH = 40
"""Most cases within cases."""
CUTS = 3
"""Most cases of signs among them."""
EVERY = 8000
"""Most products that are tried."""
MOST = 600
"""Most products that share monomials."""
SECONDS = 10.0
"""Of the processor for one obligation."""
SOON = 300_000
"""Work of z3 for a question about a few facts."""
LATER = 3_000_000
"""Work of z3 for a question about the facts of a case."""


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
        self.good: list[tuple[frozenset[Any], int]] = []

    def tree(self, case: Case, depth: int = 0) -> Node:
        """A tree that refutes a case."""
        if depth > DEPTH:
            raise NotFound("too many cases within cases")
        facts = _facts(case)
        inner = case
        signs = []
        for number, sign, total in self._signs(case, facts):
            signs.append((inner, number, sign, total))
            inner = inner.signed(number, sign)
        node = self._node(inner, _facts(inner) if signs else facts, depth)
        for outer, number, sign, total in reversed(signs):
            if not _refutes(outer, node):
                node = ["den", number, sign, total, node]
        return node

    def _node(self, case: Case, facts: Facts, depth: int) -> Node:
        found = self._sum(facts, 1)
        for used, degree in self.good:
            if found is None and used <= set(facts):
                found = self._sum({name: facts[name] for name in used}, degree)
        if found is not None:
            return found
        answer, model = self._asked(facts.values(), LATER)
        if answer == z3.unsat:
            found = self._closed(facts)
            if found is not None:
                return found
        return self._split(case, facts, model, depth)

    def _closed(self, facts: Facts, degrees: Iterable[int] = range(2, 4)) -> Node | None:
        """A sum of facts that z3 finds to contradict each other."""
        few = self._core(facts)
        unknowns = set[str]().union(*(names(fact.poly) for fact in few.values()))
        few |= {name: fact for name, fact in facts.items() if name.startswith("c")}
        near = {name: fact for name, fact in facts.items()
                if len(names(fact.poly)) == 1 and names(fact.poly) <= unknowns}  # fmt: skip
        for degree in degrees:
            signed = near | few
            for chosen in (few, signed, signed | _squares(few))[: 2 + (degree < 4)]:
                found = self._sum(chosen, degree)
                if found is not None:
                    used = {name for item in found[1] for name in item[1]}
                    used |= {item[0] for item in found[2]}
                    self.good.insert(0, (frozenset(used), degree))
                    del self.good[8:]
                    return found
        return None

    def _core(self, facts: Facts) -> Facts:
        """A small subset of the facts that still contradict each other."""
        kept, size = list(facts), max(1, len(facts) // 2)
        while size:
            place = 0
            while place < len(kept):
                less = kept[:place] + kept[place + size :]
                if self._asked([facts[name] for name in less], SOON)[0] == z3.unsat:
                    kept = less
                else:
                    place += size
            size //= 2
        return {name: facts[name] for name in kept}

    def _signs(self, case: Case, facts: Facts) -> Iterator[tuple[int, int, Node]]:
        """Quotients whose denominators have a sign, each with a sum that shows it."""
        seen = set(case.signs)
        for number, atom in enumerate(case.problem.atoms):
            if not isinstance(atom, Quotient) or key(atom.below) in seen:
                continue
            below = case.plain(atom.below)
            if any(name.startswith("?") for name in names(below)):
                continue
            for sign in (1, -1):
                total = self._contradicted({**facts, "*": Fact(add({}, below, -sign), ">=")})
                if total is not None:
                    seen.add(key(atom.below))
                    yield number, sign, total
                    break

    def _contradicted(self, facts: Facts) -> Node | None:
        unknowns = names(facts["*"].poly)
        near = {name: fact for name, fact in facts.items() if names(fact.poly) <= unknowns}
        for degree in (1, 2):
            found = self._sum(near, degree)
            if found is not None:
                return found
        answer, _ = self._asked(facts.values(), SOON)
        return self._closed(facts) if answer == z3.unsat else None

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
        """The cases of a sign: of a factor of contradictory facts, or of an unknown.

        If all of them have a known sign, a sum of products of more facts is tried.
        """
        core = self._core(facts).values()
        chosen = [fact for name, fact in facts.items() if name[-1] in "+-"]
        read = [factor for fact in (*core, *chosen) for factor in _factors(fact.poly)]
        read += [var(name) for fact in core for name in sorted(names(fact.poly))]
        cuts = sum(1 for name in facts if name.startswith("c"))
        free = None if cuts >= CUTS else self._of_either_sign(read, facts)
        if free is None:
            found = self._closed(facts, range(4, DEGREE + 1))
            if found is None:
                raise NotFound("no case is left to be split")
            return found
        name, cut = f"c{cuts}", Fact(free, ">=")
        cases = [case.having(name, cut), case.having(name, negated(cut))]
        return self._cases(["cut", name, _told(cut.poly)], case, cases, depth)

    def _of_either_sign(self, polys: Iterable[Polynomial], facts: Facts) -> Polynomial | None:
        """The first of these polynomials whose sign no sum of facts shows; None if there is
        none.
        """
        for p in polys:
            sides = (Fact(add({}, p, sign), ">") for sign in (1, -1))
            if all(self._sum({**facts, "*": side}, 1) is None for side in sides):
                return p
        return None

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
            solver.set("rlimit", work)
            solver.add(*map(_formula, facts))
            answer = solver.check()
            if answer != z3.unknown:
                return answer, solver.model() if answer == z3.sat else None
        return z3.unknown, None

    def _sum(self, facts: Facts, degree: int) -> Node | None:
        """A sum of products of at most ``degree`` facts and of multiples of equations."""
        if process_time() > self.end:
            raise NotFound("out of time")
        products = _products(facts, degree)
        multiples = _multiples(facts, products, degree)
        if len(products) + len(multiples) > EVERY:
            return None
        products = _able_to_cancel(products, multiples)
        polys = {used: p for used, (p, _) in products.items()} | multiples
        for part in _linked(polys):
            above = {used: products[used][1] for used in part if used in products}
            if any(above.values()) and len(part) <= MOST:
                found = self._program({used: polys[used] for used in part}, above)
                if found is not None:
                    return found
        return None

    def _program(self, polys: Mapping[Used, Polynomial], above: Mapping[Used, bool]) -> Node | None:
        """A sum of multiples of these, by exact linear programming; multiples in ``above`` are >=
        0.
        """
        if process_time() > self.end:
            raise NotFound("out of time")
        rows = dict[Any, list[Any]]()
        solver = z3.SolverFor("QF_LRA")
        solver.set("rlimit", LATER)
        shares = {known: z3.Real(f"x{k}") for k, known in enumerate(polys)}
        for known, p in polys.items():
            for monomial, c in p.items():
                rows.setdefault(monomial, []).append(z3.RealVal(str(c)) * shares[known])
        solver.add(*(z3.Sum(row) == 0 for row in rows.values()))
        solver.add(*(shares[known] >= 0 for known in above))
        solver.add(z3.Sum([shares[known] for known, strict in above.items() if strict]) > 0)
        if solver.check() != z3.sat:
            return None
        model = solver.model()
        value = {known: model.eval(share, True).as_fraction() for known, share in shares.items()}
        equations = dict[Any, Polynomial]()
        for known in polys:
            if known not in above:
                equations.setdefault(known[0], {})[known[1]] = value[known]
        told = [[name, _told(p)] for name, p in equations.items() if any(p.values())]
        return ["sum", [_item(value[used], used) for used in above if value[used]], told]


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
    terms = [
        prod([_real(name) ** power if power > 1 else _real(name) for name, power in monomial],
             start=z3.RealVal(str(c)))
        for monomial, c in formula.poly.items()
    ]  # fmt: skip
    value = z3.Sum([z3.RealVal(0), *terms])
    return {"=": value == 0, ">": value > 0, ">=": value >= 0}[formula.kind]


def _squares(facts: Facts) -> Facts:
    """Candidate squares for completing a fact; their roots are in their names."""
    roots = [_derivative(p, name) for p, _ in facts.values() for name in names(p)
             if max(dict(m).get(name, 0) for m in p) == 2]  # fmt: skip
    told = (f"{ROOT}{json.dumps(_told(root))}" for root in roots)
    return {name: Fact(mul(root, root), ">=") for name, root in zip(told, roots, strict=True)}


def _derivative(p: Polynomial, name: str) -> Polynomial:
    return {rest: c * dict(m)[name] for m, c in p.items()
            if (rest := _rest(m, ((name, 1),))) is not None}  # fmt: skip


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


def _products(facts: Facts, degree: int) -> dict[Used, tuple[Polynomial, bool]]:
    """Products of inequalities, and whether they are above 0."""
    above = {name: fact for name, fact in facts.items() if fact.kind != "="}
    level: dict[Used, tuple[Polynomial, bool]] = {(): (const(1), True)}
    found = dict(level)
    for _ in range(degree):
        if len(found) > EVERY:
            break
        level = {
            (*used, name): (mul(p, fact.poly), strict and fact.kind == ">")
            for used, (p, strict) in level.items()
            for name, fact in above.items()
            if not used or name >= used[-1]
        }
        found |= level
    return found


def _multiples(
    facts: Facts, products: Mapping[Used, tuple[Polynomial, bool]], degree: int
) -> dict[Used, Polynomial]:
    """Multiples of equations that have a monomial in common with products."""
    equations = {name: fact.poly for name, fact in facts.items() if fact.kind == "="}
    known = {m for p, _ in products.values() for m in p} if equations else set()
    return {
        (name, rest): mul(p, {rest: 1})
        for name, p in equations.items()
        for whole in known
        for part in p
        if (rest := _rest(whole, part)) is not None and sum(power for _, power in rest) <= degree
    }


def _rest(whole: Monomial, part: Monomial) -> Monomial | None:
    """The quotient of two monomials; None if it is not a monomial."""
    powers = dict(whole)
    for name, power in part:
        powers[name] = powers.get(name, 0) - power
    if min(powers.values(), default=0) < 0:
        return None
    return tuple((name, power) for name, power in sorted(powers.items()) if power)


def _able_to_cancel(
    products: dict[Used, tuple[Polynomial, bool]], multiples: Mapping[Used, Polynomial]
) -> dict[Used, tuple[Polynomial, bool]]:
    """Products without those that have a monomial with only one sign among all products."""
    free = {monomial for p in multiples.values() for monomial in p}
    while True:
        signs = {(m, c > 0) for p, _ in products.values() for m, c in p.items()}
        alone = {m for m, up in signs if (m, not up) not in signs} - free
        kept = {known: item for known, item in products.items() if not alone & set(item[0])}
        if len(kept) == len(products):
            return kept
        products = kept


def _linked(polys: Mapping[Used, Polynomial]) -> Iterator[list[Used]]:
    """Groups of polynomials linked by shared monomials; a sum is 0 only if it is 0 in each
    group.
    """
    groups = dict[Any, list[Used]]()
    for known, p in polys.items():
        touched = {id(groups[m]): groups[m] for m in p if m in groups}
        group = max(touched.values(), key=len, default=list[Used]())
        group.append(known)
        for other in touched.values():
            if other is not group:
                group += other
                groups.update((m, group) for item in other for m in polys[item])
        groups.update((m, group) for m in p)
    yield from ([known] for known, p in polys.items() if not p)
    yield from {id(group): group for group in groups.values()}.values()


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
        if claim.id in wanted & set(entries) and uses_z3(claim.method):
            rows = find(claim, entries[claim.id], given.seconds)["obligations"]
            shown = sum(1 for item in rows if item[3])
            sys.stdout.write(f"{claim.id}: {shown} of {len(rows)}\n")


if __name__ == "__main__":
    main()
