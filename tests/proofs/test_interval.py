"""Intervals contain both the real result and the one that C computes."""

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


def test_elementary_functions_hold_what_a_library_within_its_error_may_say():
    rng = random.Random("elementary")
    for call in (arb.exp, arb.tanh, lambda x: -x.exp()):
        for _ in range(300):
            low, high = sorted(rng.uniform(-3, 3) for _ in range(2))
            found = iv.elementary(call, Interval(low, high))
            for x in (low, high, rng.uniform(low, high)):
                exact = call(arb(x))
                error = abs(exact) * arb(iv.LIBM)
                assert arb(found.lo) <= exact - error
                assert exact + error <= arb(found.hi)


def test_quotients_of_forms_hold_what_they_are_of_one_number():
    rng = random.Random("forms")
    for _ in range(300):
        x = Interval(1e-9, rng.uniform(0.1, 2), 1)
        above, below = (Interval(*sorted(rng.uniform(0.5, 4) for _ in range(2))) for _ in range(2))
        found = iv.divide(iv.multiply(x, above), iv.multiply(x, below))
        ends = [Fraction(n) / Fraction(d) for n in (above.lo, above.hi)
                for d in (below.lo, below.hi)]  # fmt: skip

        assert Fraction(found.lo) <= min(ends)
        assert max(ends) <= Fraction(found.hi)
        assert found.hi < 1.001 * float(max(ends))
