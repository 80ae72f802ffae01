"""Products of facts that add up to 0, for `wmr_proofs.find`.

Facts are multiplied by each other and by unknowns of known sign.  Terms cancel only in products of
the same physical unit.  Units are computed: all terms of a fact have the same.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import chain, combinations_with_replacement, islice
from random import Random
from typing import Any, TypeAlias

import z3
from flint import fmpz_mat
from scipy.optimize import linprog
from scipy.sparse import coo_matrix

from .check import Fact, Monomial, Polynomial, const, joined, mul, names

Facts: TypeAlias = dict[str, Fact]
Used: TypeAlias = tuple[Any, ...]
"""Names of the facts in a product, or of an equation and the monomial of its multiple."""
Products: TypeAlias = dict[Used, tuple[Polynomial, bool]]
"""Polynomials that are not negative, and whether they are above 0."""

EFFORTS = ((0, 1), (1, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 1), (2, 2), (2, 3), (3, 1))
"""Degree above the highest of a fact, and most facts in a product, from cheap to costly."""
MOST_DEGREE = 6
"""Largest degree of products of several facts."""
FEW = 11
"""Most facts of which three are multiplied."""
MONOMIALS = 40_000
"""Most products of unknowns of known sign."""
GROUP = 4000
"""Most products of the same unit."""
EXACT = 12
"""Most polynomials that are added up exactly at once."""
TINY = 1e-9
"""Largest number in floating point that counts as 0."""
EFFORT = 3_000_000
"""Work of z3 for an exact sum."""
PATIENCE = 20.0
"""Seconds for a sum in floating point."""


def products(facts: Facts, most: int) -> Iterator[Used]:
    """All products of at most ``most`` inequalities."""
    above = [name for name, fact in facts.items() if fact.kind != "="]
    for count in range(most + 1):
        yield from combinations_with_replacement(above, count)


def product_of(facts: Facts, used: Used, known: Products) -> tuple[Polynomial, bool]:
    """One product, and whether it is above 0; ``known`` keeps it and those of its first facts."""
    if not used:
        return const(1), True
    if used not in known:
        p, strict = product_of(facts, used[:-1], known)
        fact = facts[used[-1]]
        known[used] = mul(p, fact.poly), strict and fact.kind == ">"
    return known[used]


def groups(facts: Facts, core: Iterable[str]) -> Iterator[list[Used]]:
    """Products of the same unit, from few to many; each group has products of all of ``core``."""
    signs = dict[str, str]()
    others = Facts()
    for name, fact in sorted(facts.items(), key=lambda item: item[1].kind != ">"):
        match [*fact.poly, fact.kind]:
            case [((str(unknown), 1),), ">" | ">="] if unknown not in signs:
                signs[unknown] = name
            case _:
                others[name] = fact
    needed = {name: others[name] for name in core if name in others and others[name].kind != "="}
    polys = [fact.poly for fact in facts.values()]
    units = _units(polys)
    for more, most in EFFORTS:
        degree = max(map(degree_of, polys)) + more
        if (most > 1 and degree > MOST_DEGREE) or (most > 2 and len(needed) > FEW):
            continue
        kinds = dict[Used, tuple[int, int]]()
        for used in chain(products(others, min(most, 2)), products(needed, most)):
            size = sum(degree_of(facts[name].poly) for name in used)
            first = chain.from_iterable(next(iter(facts[name].poly), ()) for name in used)
            if size <= degree:
                kinds[used] = sum(power * units[name] for name, power in first), size
        factors = defaultdict[int, list[Used]](list)
        signed = (chosen for power in range(degree + 1)
                  for chosen in combinations_with_replacement(sorted(signs), power))  # fmt: skip
        for chosen in islice(signed, MONOMIALS):
            factors[sum(units[name] for name in chosen)].append(chosen)
        reached = [
            {unit + other for used, (unit, size) in kinds.items() if name in used
             for other, (chosen, *_) in factors.items() if size + len(chosen) <= degree}
            for name in needed
        ] or [{unit for used, (unit, _) in kinds.items() if used}]  # fmt: skip
        found = []
        for goal in set.intersection(*reached):
            several = (
                (*(signs[name] for name in chosen), *used)
                for used, (unit, size) in kinds.items()
                for chosen in factors.get(goal - unit, ())
                if size + len(chosen) <= degree
            )
            group = list(islice(several, GROUP + 1))
            if len(group) <= GROUP:
                found.append(group)
        yield from sorted(found, key=len)


def _units(polys: Sequence[Polynomial]) -> dict[str, int]:
    """A number for each unknown; products that can have the same unit have the same sum."""
    unknowns = sorted(set[str]().union(*map(names, polys)))
    rows = set[tuple[int, ...]]()
    for p in polys:
        first, *rest = ([dict(m).get(name, 0) for name in unknowns] for m in p or [()])
        rows |= {tuple(a - b for a, b in zip(first, other, strict=True)) for other in rest}
    flat = [power for row in rows for power in row]
    basis, rank = fmpz_mat(len(rows), len(unknowns), flat).nullspace()
    scale = Random(1).choices(range(2**60), k=rank)
    return {name: sum(int(basis[row, k]) * scale[k] for k in range(rank))
            for row, name in enumerate(unknowns)}  # fmt: skip


def degree_of(p: Polynomial) -> int:
    """Highest degree of a term."""
    return max((sum(power for _, power in monomial) for monomial in p), default=0)


def multiples(facts: Facts, found: Products, rounds: int) -> dict[Used, Polynomial]:
    """Multiples of equations that share a monomial with products, then with such multiples."""
    equations = {name: fact.poly for name, fact in facts.items() if fact.kind == "="}
    known: Polynomial = {m: 1 for p, _ in found.values() for m in p} if equations else {}
    most = degree_of(known) + 1
    several = dict[Used, Polynomial]()
    for _ in range(rounds):
        several |= {
            (name, rest): {joined(m, rest): c for m, c in p.items()}
            for name, p in equations.items()
            for whole in known
            for part in p
            if (rest := quotient(whole, part)) is not None
            and degree_of({rest: 1}) + degree_of(p) <= most
        }
        known |= {m: 1 for p in several.values() for m in p}
    return several


def quotient(whole: Monomial, part: Monomial) -> Monomial | None:
    """The quotient of two monomials; None if it is not a monomial."""
    powers = dict(whole)
    for name, power in part:
        powers[name] = powers.get(name, 0) - power
    if min(powers.values(), default=0) < 0:
        return None
    return tuple((name, power) for name, power in sorted(powers.items()) if power)


def able_to_cancel(found: Products, free: Mapping[Used, Polynomial]) -> Products:
    """Products without those that have a monomial with only one sign among all products."""
    both = {monomial for p in free.values() for monomial in p}
    while True:
        signs = {(m, c > 0) for p, _ in found.values() for m, c in p.items()}
        alone = {m for m, up in signs if (m, not up) not in signs} - both
        kept = {used: item for used, item in found.items() if not alone & set(item[0])}
        if len(kept) == len(found):
            return kept
        found = kept


def shares(
    polys: Mapping[Used, Polynomial], above: Mapping[Used, bool]
) -> dict[Used, Fraction] | None:
    """Factors for which polynomials add up to 0: of those in ``above`` at least 0, of one that
    is marked there above 0.

    Among many, floating point chooses those that are then added up exactly.
    """
    if len(polys) > EXACT:
        polys = {used: polys[used] for used in _chosen(polys, above)}
    rows = defaultdict[Monomial, list[Any]](list)
    solver = z3.SolverFor("QF_LRA")
    solver.set("rlimit", EFFORT)
    factors = {used: z3.Real(f"x{k}") for k, used in enumerate(polys)}
    for used, p in polys.items():
        for monomial, c in p.items():
            rows[monomial].append(z3.RealVal(str(c)) * factors[used])
    solver.add(*(z3.Sum(row) == 0 for row in rows.values()))
    solver.add(*(factor >= 0 for used, factor in factors.items() if used in above))
    solver.add(z3.Sum([factor for used, factor in factors.items() if above.get(used)]) > 0)
    if solver.check() != z3.sat:
        return None
    model = solver.model()
    return {used: model.eval(factor, True).as_fraction() for used, factor in factors.items()}


def _chosen(polys: Mapping[Used, Polynomial], above: Mapping[Used, bool]) -> list[Used]:
    """Polynomials that add up to 0 in floating point; none if it finds no sum."""
    rows = dict[Monomial, int]()
    entries = [(1.0, 0, column) for column, used in enumerate(polys) if above.get(used)]
    for column, p in enumerate(polys.values()):
        entries += [(float(c), rows.setdefault(m, len(rows) + 1), column) for m, c in p.items()]
    values, *places = zip(*entries, strict=True)
    result = linprog(
        [used in above for used in polys],
        A_eq=coo_matrix((values, places), (len(rows) + 1, len(polys))).tocsc(),
        b_eq=[1, *[0] * len(rows)],
        bounds=[(0 if used in above else None, None) for used in polys],
        method="highs-ds",
        options={"time_limit": PATIENCE},
    )
    found = result.x if result.status == 0 else []
    return [used for used, share in zip(polys, found, strict=False) if abs(share) > TINY]
