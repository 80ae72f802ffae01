"""Elements of a fraction field over the rationals, with roots, sines and logarithms as atoms.

Every generator has a domain (positive, nonnegative, any), so that the sign of a polynomial follows
from the signs of its coefficients.  Atoms are spare generators, taken on demand, one per argument;
roots and sine-cosine pairs bring the relation S^2 = argument or s^2 = 1 - c^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from operator import truediv
from typing import Any

from flint import fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from wmr_proofs.graph import UndecidedError
from wmr_proofs.regions import FREE, NONNEGATIVE, NONZERO, POSITIVE

Exponents = tuple[int, ...]


class QuotientField:
    """All quotients of polynomials in named generators."""

    def __init__(self, names: Sequence[str]) -> None:
        self.ring = fmpq_mpoly_ctx.get(tuple(names))
        self.one = self.ring.constant(1)
        self.generators = [Quotient(self, item, self.one) for item in self.ring.gens()]

    def __call__(self, value: Any) -> Quotient:
        """Element of a polynomial of this ring, a rational or an element."""
        if isinstance(value, Quotient):
            return value
        if isinstance(value, fmpq_mpoly):
            return Quotient(self, value, self.one)
        if not isinstance(value, fmpq):
            exact = Fraction(value)
            value = fmpq(exact.numerator, exact.denominator)
        return Quotient(self, self.ring.constant(value), self.one)

    def polynomial(self, terms: Mapping[Exponents, fmpq]) -> fmpq_mpoly:
        """The polynomial with these coefficients."""
        return self.ring.from_dict(dict(terms))

    def over(self, numer: fmpq_mpoly, denom: fmpq_mpoly) -> Quotient:
        """numer/denom in lowest terms.  ZeroDivisionError if denom is 0."""
        if denom.is_zero():
            raise ZeroDivisionError("a quotient with the denominator 0")
        if not denom.is_constant():
            shared = numer.gcd(denom)
            if not shared.is_one():
                numer, denom = numer / shared, denom / shared
        return self.monic(numer, denom)

    def monic(self, numer: fmpq_mpoly, denom: fmpq_mpoly) -> Quotient:
        """Quotient of coprime polynomials whose denominator has the leading coefficient 1."""
        first = denom.leading_coefficient()
        if first != 1:
            numer, denom = numer / first, denom / first
        return Quotient(self, numer, denom)


class Quotient:
    """One element in its unique form, so that equal elements have equal parts."""

    __slots__ = ("_hash", "denom", "field", "numer")

    def __init__(self, field: QuotientField, numer: fmpq_mpoly, denom: fmpq_mpoly) -> None:
        self.field, self.numer, self.denom = field, numer, denom
        self._hash: int | None = None

    @property
    def number(self) -> Fraction | None:
        """Its value if it is rational; None if it contains generators."""
        if not (self.numer.is_constant() and self.denom.is_constant()):
            return None
        found = self.numer.leading_coefficient() if self else fmpq(0)
        return Fraction(int(found.numerator), int(found.denominator))

    def __bool__(self) -> bool:
        """True unless it is 0."""
        return not self.numer.is_zero()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Quotient | int | Fraction):
            return NotImplemented
        twin = self.field(other)
        return bool(self.numer == twin.numer and self.denom == twin.denom)

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash((*self.numer.terms(), *self.denom.terms()))
        return self._hash

    def __neg__(self) -> Quotient:
        return Quotient(self.field, -self.numer, self.denom)

    def __add__(self, other: Any) -> Quotient:
        twin, field = self.field(other), self.field
        if self.denom == twin.denom:
            return field.over(self.numer + twin.numer, self.denom)
        shared = self.denom.gcd(twin.denom)
        left, right = twin.denom / shared, self.denom / shared
        return field.over(self.numer * left + twin.numer * right, self.denom * left)

    def __sub__(self, other: Any) -> Quotient:
        return self + -self.field(other)

    def __mul__(self, other: Any) -> Quotient:
        twin = self.field(other)
        one, two = self.field.over(self.numer, twin.denom), self.field.over(twin.numer, self.denom)
        return Quotient(self.field, one.numer * two.numer, one.denom * two.denom)

    def __truediv__(self, other: Any) -> Quotient:
        return self * self.field(other).inverse()

    def inverse(self) -> Quotient:
        """1/self.  ZeroDivisionError for 0."""
        if not self:
            raise ZeroDivisionError("the inverse of 0")
        return self.field.monic(self.denom, self.numer)

    def __pow__(self, power: int) -> Quotient:
        if power < 0:
            return self.inverse() ** -power
        return Quotient(self.field, self.numer**power, self.denom**power)

    def __radd__(self, other: Any) -> Quotient:
        return self + other

    def __rsub__(self, other: Any) -> Quotient:
        return -self + other

    def __rmul__(self, other: Any) -> Quotient:
        return self * other

    def __rtruediv__(self, other: Any) -> Quotient:
        return self.field(other) / self


MOST_TERMS = 60
"""Longer polynomials are not factored: their coefficients tell the sign, or nothing does."""


class Algebra:
    """The field of one case: generators by name, atoms by (function, argument)."""

    def __init__(self, domains: Mapping[str, str], spare: int) -> None:
        self.domains = [*domains.values()]
        self.count, self.spare = len(self.domains), spare
        names = [f"x{k}" for k in range(self.count)] + [f"atom{k}" for k in range(spare)]
        self.field = QuotientField(names or ["x0"])
        self.generators = self.field.generators
        self.by_name = dict(zip(domains, self.generators, strict=False))
        self.atoms: dict[tuple[str, Any], Any] = {}
        self.squares: dict[int, Any] = {}
        self.arguments: dict[int, tuple[str, Any]] = {}

    def number(self, value: Fraction | float) -> Any:
        """A rational, exactly."""
        return self.field(value)

    def atom(self, function: str, argument: Any, domain: str) -> Any:
        """Generator that represents ``function(argument)``."""
        key = (function, argument)
        if key not in self.atoms:
            index = len(self.domains)
            if index >= len(self.generators):
                raise UndecidedError("more atoms than the field has room for")
            self.domains.append(domain)
            self.atoms[key] = self.generators[index]
            self.arguments[index] = key
        return self.atoms[key]

    def index(self, generator: Any) -> int:
        """Position of a generator."""
        return self.generators.index(generator)

    def relate(self, generator: Any, square: Any) -> None:
        """Add the relation generator^2 = square."""
        self.squares[self.index(generator)] = square

    def reduced(self, element: Any) -> Any:
        """Element with every square of a root or a sine replaced."""
        for index, square in self.squares.items():
            parts = (self._lower(part, index, square) for part in (element.numer, element.denom))
            element = truediv(*parts)
        return element

    def _lower(self, poly: Any, index: int, square: Any) -> Any:
        if poly.degrees()[index] < 2:
            return self.field(poly)
        parts: dict[int, dict[Exponents, Any]] = {}
        for monomial, coefficient in poly.terms():
            power, rest = monomial[index], list(monomial)
            rest[index] = power % 2
            part = parts.setdefault(power // 2, {})
            part[tuple(rest)] = part.get(tuple(rest), 0) + coefficient
        total = self.field(0)
        for power, part in parts.items():
            total += self.field(self.field.polynomial(part)) * square**power
        return total

    def polynomial_sign(self, poly: Any) -> str | None:
        """Sign ``+ - 0 +0 -0`` (the last two: or zero); None if the coefficients do not determine
        it.
        """
        if poly == 0:
            return "0"
        positive = negative = strict = False
        for monomial, coefficient in poly.terms():
            kind = self._monomial(monomial)
            if kind is None:
                return None
            positive, negative = positive or coefficient > 0, negative or coefficient < 0
            strict = strict or kind == POSITIVE
        if positive and negative:
            return None
        return ("+" if positive else "-") + ("" if strict else "0")

    def _monomial(self, monomial: tuple[int, ...]) -> str | None:
        kind = POSITIVE
        for power, domain in zip(monomial, self.domains, strict=False):
            if power % 2 and domain in (FREE, NONZERO):
                return None
            if power and domain not in (POSITIVE, NONZERO):
                kind = NONNEGATIVE
        return kind

    def sign(self, element: Any) -> str | None:
        """Sign of an element, by its coefficients or by its factors."""
        element = self.reduced(element)
        if not element:
            return "0"
        top, bottom = self._factored_sign(element.numer), self._factored_sign(element.denom)
        if top is None or bottom is None:
            return None
        flipped = top[0] != bottom[0]
        return ("-" if flipped else "+") + top[1:]

    def never_zero(self, element: Any) -> bool:
        """True if no factor of an element can be 0."""
        element = self.reduced(element)
        if self.sign(element) in ("+", "-"):
            return True
        if not element or len(element.numer) > MOST_TERMS:
            return False
        return all(
            factor in self._nonzero or self.polynomial_sign(factor) in ("+", "-")
            for factor, _ in element.numer.factor()[1]
        )

    @property
    def _nonzero(self) -> list[Any]:
        pairs = zip(self.generators, self.domains, strict=False)
        return [generator.numer for generator, domain in pairs if domain == NONZERO]

    def _factored_sign(self, poly: Any) -> str | None:
        direct = self.polynomial_sign(poly)
        if direct is not None or len(poly) > MOST_TERMS:
            return direct
        content, factors = poly.factor()
        negative, weak = content < 0, False
        for factor, times in factors:
            found = self.polynomial_sign(factor)
            if found is None and times % 2:
                return None
            weak = weak or found is None or found.endswith("0")
            negative ^= bool(found and found[0] == "-" and times % 2)
        return ("-" if negative else "+") + ("0" if weak else "")
