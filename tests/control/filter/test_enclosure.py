"""Intervals that are rounded outward, against fractions and balls of 200 bits."""

from fractions import Fraction

import flint
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmr_ctrl.control.filter.enclosure import LIBM, Span, above, below, cosine, exp, root, sine_over
from wmr_ctrl.core.errors import ScenarioError


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(0.01, 20))
def test_enclosures_hold_exact_results(a, b, c):
    one, other, below = (Fraction(item) for item in (a, b, c))
    x, y, z = Span.of(a), Span.of(b), Span.of(c)
    for found, exact in (
        (x + y, one + other), (x - y, one - other), (x * y, one * other), (x / z, one / below),
    ):  # fmt: skip
        assert Fraction(float(found.lo)) <= exact <= Fraction(float(found.hi))
    assert Fraction(float(root(z).lo)) ** 2 <= below <= Fraction(float(root(z).hi)) ** 2
    assert exp(Span.of(a, a + c)).lo <= np.exp(a) <= np.exp(a + c) <= exp(Span.of(a, a + c)).hi


FUNCTIONS = {
    "exp": (np.exp, flint.arb.exp, -700.0, 700.0), "arctan": (np.arctan, flint.arb.atan, -1e6, 1e6),
    "arctanh": (np.arctanh, flint.arb.atanh, -0.999999, 0.999999),
    "arccosh": (np.arccosh, flint.arb.acosh, 1.0, 1e6),
}  # fmt: skip


@pytest.mark.parametrize("name", FUNCTIONS)
def test_numpys_functions_are_as_exact_as_the_enclosures_count_on(name):
    """For numbers of every size: eight units in the last place are assumed, far fewer occur."""
    numpy, ball, low, high = FUNCTIONS[name]
    rng = np.random.default_rng(0)
    values = rng.uniform(low, high, 4000)
    near = (1.0 if name == "arccosh" else 0.0) + 10.0 ** rng.uniform(-12, -0.01, 4000)
    for x in np.concatenate([values, near]):
        with flint.ctx.workprec(200):
            exact, found = ball(flint.arb(float(x))), flint.arb(float(numpy(x)))
            assert abs(found - exact) <= abs(exact) * flint.arb(LIBM) / 2


@pytest.mark.parametrize("enclosure, ball", [
    (cosine, lambda w: w.cos()), (sine_over, lambda w: w.sin() / w),
])  # fmt: skip
@pytest.mark.parametrize("width", [0.0, 1e-6, 0.01, 3.0])
def test_swings_are_enclosed_on_both_sides_of_critical_damping(enclosure, ball, width):
    """cos(sqrt x) and sin(sqrt x)/sqrt x for x from -900 to 900 and beyond, in complex balls."""
    rng = np.random.default_rng(1)
    start = np.concatenate([rng.uniform(-900, 900, 800), rng.uniform(-0.01, 0.01, 200), [9.9e5]])
    found = enclosure(Span(start, start + width))
    inside = np.minimum(start + width * rng.random(len(start)), start + width)
    for x, low, high in zip(inside, found.lo, found.hi, strict=True):
        with flint.ctx.workprec(200):
            exact = ball(flint.acb(float(x)).sqrt()).real
            assert flint.arb(float(low)) <= exact <= flint.arb(float(high))


@pytest.mark.filterwarnings("ignore:(overflow|invalid value) encountered in nextafter")
def test_the_next_doubles_are_numpys():
    """The next doubles equal NumPy's for random bits, both signs, infinities and NaN.

    The arrays are long, short, strided and broadcast.
    """
    bits = np.random.default_rng(0).integers(-(2**63), 2**63 - 1, 3000)
    ends = np.array(
        [0.0, 5e-324, 2.2250738585072014e-308, 1.0, np.finfo(float).max, np.inf, np.nan]
    )
    values = np.concatenate([bits.view(float), ends, -ends])
    for some in (values, values[::2], values[-20:], np.broadcast_to(values, (3, len(values)))):
        for found, end in ((below(some), -np.inf), (above(some), np.inf)):
            np.testing.assert_array_equal(found, np.nextafter(some, end))
            assert (np.signbit(found) == np.signbit(np.nextafter(some, end)))[~np.isnan(some)].all()


def test_quotient_without_a_bound_is_refused_in_words():
    with pytest.raises(ScenarioError, match=r"\[filter\]: its numbers"):
        Span.of(1.0) / Span(np.array(0.0), np.array(1.0))
