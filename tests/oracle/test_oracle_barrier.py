"""The oracle's barrier terms against their definitions, Eqs. (10)-(20), at 50 digits."""

import math
from dataclasses import astuple

import mpmath
import pytest

from tests.control.barrier.test_stable import LIMITS, close, exact, points
from tests.oracle.barrier import barrier


@pytest.mark.parametrize("u1, u2", LIMITS)
def test_barrier_equals_its_definition_at_50_digits(u1, u2):
    with mpmath.workdps(50):
        for c, v in points(u1, u2, 300, 1e-3):
            found = barrier(v, c, u1, u2)
            quotient, q, target, value = exact(c, v, u1, u2)
            wanted = target, v - target, value, quotient, q
            assert all(map(close, astuple(found), wanted)), (c, v, found)


def test_border_of_the_saturated_regions_is_decided_exactly():
    u1, u2 = 1.0, 0.5  # 1/delta = 2 and all of these are exact in binary
    assert barrier(0.6, 2.5, u1, u2).v_c1 == 0.5
    assert barrier(0.6, math.nextafter(2.5, 3.0), u1, u2).q > 0.05
    assert barrier(0.5, 2.5, u1, u2).q == 0.0
