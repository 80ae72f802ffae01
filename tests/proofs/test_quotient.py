"""Quotients of polynomials: one form for each, and the laws of a field."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmr_proofs.methods.field import QuotientField

FIELD = QuotientField(("x", "y"))
X, Y = FIELD.generators
NUMBERS = st.fractions(min_value=-5, max_value=5, max_denominator=7)
POINT = {"x": Fraction(3, 7), "y": Fraction(-5, 11)}


def value(q):
    """The quotient at `POINT`, by the coefficients of both its parts."""

    def of(poly):
        total = Fraction(0)
        for (a, b), c in poly.terms():
            share = Fraction(int(c.numerator), int(c.denominator))
            total += share * POINT["x"] ** int(a) * POINT["y"] ** int(b)
        return total

    return of(q.numer) / of(q.denom)


@st.composite
def quotients(draw):
    """Quotients of polynomials of degree one in each generator."""
    a, b, c, d = (draw(NUMBERS) for _ in range(4))
    below = c * X * Y + d + 1
    return (a * X + b * Y + c) / (below if value(below) else FIELD(1))


@given(quotients(), quotients())
def test_it_computes_as_rationals_do(p, q):
    assert value(p + q) == value(p) + value(q)
    assert value(p - q) == value(p) - value(q)
    assert value(p * q) == value(p) * value(q)
    assert value(p**3) == value(p) ** 3
    if value(q):
        assert value(p / q) == value(p) / value(q)


@given(quotients(), quotients())
@pytest.mark.slow
def test_equal_quotients_are_written_alike(p, q):
    left, right = (p + q) ** 2, p * p + 2 * p * q + q * q

    assert left == right
    assert hash(left) == hash(right)
    assert not left - right


def test_lowest_terms():
    found = (2 * X * X - 2 * Y * Y) / (4 * X - 4 * Y)

    assert found == (X + Y) / 2
    assert found.denom.is_one()


def test_numbers():
    assert (X / (3 * X)).number == Fraction(1, 3)
    assert FIELD(0).number == 0
    assert (X + 1).number is None


@pytest.mark.parametrize(
    "divided", [lambda: X / (Y - Y), lambda: (X - X) ** -1, lambda: 1 / (X - X)]
)
def test_nothing_is_divided_by_0(divided):
    with pytest.raises(ZeroDivisionError):
        divided()
