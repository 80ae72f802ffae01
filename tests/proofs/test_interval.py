"""Intervals hold both the real result and what C computes."""

import math
import random
from fractions import Fraction

import pytest
from flint import arb, ctx

from wmr_proofs.methods import interval as iv
from wmr_proofs.methods.interval import Interval

OPERATIONS = {
    "add": (iv.add, lambda a, b: a + b),
    "multiply": (iv.multiply, lambda a, b: a * b),
    "divide": (iv.divide, lambda a, b: a / b),
}


def draw(rng):
    return rng.choice((-1, 1)) * math.ldexp(rng.random() + 0.5, rng.randint(-40, 40))


@pytest.mark.parametrize("name", OPERATIONS)
def test_operations_hold_exact_and_rounded_results(name):
    rng = random.Random(name)
    enclose, compute = OPERATIONS[name]
    for _ in range(3000):
        a, b = (sorted((draw(rng), draw(rng))) for _ in range(2))
        found = enclose(Interval(*a), Interval(*b))
        if found is None:
            continue
        x, y = (
            rng.choice((*ends, ends[0] + rng.random() * (ends[1] - ends[0]))) for ends in (a, b)
        )
        exact, rounded = compute(Fraction(x), Fraction(y)), compute(x, y)

        assert Fraction(found.lo) <= exact <= Fraction(found.hi)
        assert found.lo <= rounded <= found.hi


def test_quotient_of_forms_is_bounded_at_zero():
    x, y = Interval(0.0, 1e-9, 1), Interval(0.0, 1e-9, 2)
    total = iv.add(x, y)
    total.lo = 1e-300  # not zero, as a strict comparison would tell

    found = iv.divide(x, total)

    assert found.lo >= 0
    assert found.hi < 1 + 1e-12


@pytest.mark.parametrize("name, low, high", [("log", -300, 300), ("exp", -8, 8), ("tanh", -8, 3)])
def test_the_c_library_is_as_accurate_as_assumed(name, low, high):
    """assumption.libm: right to 2^-51 relative, on random arguments, near 1 in particular."""
    ctx.prec = 300
    rng = random.Random(name)
    for k in range(20000):
        x = math.ldexp(1 + rng.random(), rng.randint(low, high))
        if k % 2 and name == "log":
            x = 1 + rng.choice((-1, 1)) * math.ldexp(rng.random(), -rng.randint(1, 50))
        if name != "log" and k % 2:
            x = -x
        exact = getattr(arb(x), name)()

        assert abs(arb(getattr(math, name)(x)) - exact) <= abs(exact) * arb(iv.LIBM)
