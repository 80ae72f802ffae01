"""Signs of expressions with a logarithm, from the one fact ln t >= 1 - 1/t (t > 0)."""

from __future__ import annotations

from math import lcm
from typing import Any

from wmr_ctrl.proofs.methods.field import Algebra
from wmr_ctrl.proofs.methods.quotient import Exponents, Quotient


def at_least_by_lemma(algebra: Algebra, value: Any, strict: bool) -> bool:
    """Whether value = P + q ln R, with q > 0, is at least (above) 0 by P + q (1 - 1/R)."""
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
    found = algebra.sign(rest + factor * (1 - 1 / ratio))
    return found in (("+",) if strict else ("+", "+0", "0"))


def _split(algebra: Algebra, value: Any) -> tuple[Any, Any, dict[Any, int]] | None:
    """(P, q, {argument: n}) with value = P + q sum n ln(argument), n whole; else None."""
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
