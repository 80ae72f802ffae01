"""Quotients of polynomials over the rationals, in lowest terms; the polynomials are flint's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from flint import fmpq, fmpq_mpoly, fmpq_mpoly_ctx

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
        """numer/denom, brought to lowest terms.  ZeroDivisionError where denom is 0."""
        if denom.is_zero():
            raise ZeroDivisionError("a quotient with the denominator 0")
        if not denom.is_constant():
            shared = numer.gcd(denom)
            if not shared.is_one():
                numer, denom = numer / shared, denom / shared
        return self.monic(numer, denom)

    def monic(self, numer: fmpq_mpoly, denom: fmpq_mpoly) -> Quotient:
        """Of polynomials without a common factor: the denominator begins with the coefficient 1."""
        first = denom.leading_coefficient()
        if first != 1:
            numer, denom = numer / first, denom / first
        return Quotient(self, numer, denom)


class Quotient:
    """One element: the only way to write it, so that equal ones have equal parts."""

    __slots__ = ("_hash", "denom", "field", "numer")

    def __init__(self, field: QuotientField, numer: fmpq_mpoly, denom: fmpq_mpoly) -> None:
        self.field, self.numer, self.denom = field, numer, denom
        self._hash: int | None = None

    @property
    def number(self) -> Fraction | None:
        """The rational that it is; None where generators are left."""
        if not (self.numer.is_constant() and self.denom.is_constant()):
            return None
        found = self.numer.leading_coefficient() if self else fmpq(0)
        return Fraction(int(found.numerator), int(found.denominator))

    def __bool__(self) -> bool:
        """Whether it is another element than 0."""
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
