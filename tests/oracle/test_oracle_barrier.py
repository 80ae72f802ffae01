"""The oracle's barrier terms against their definitions, Eqs. (10)-(20), at 50 digits."""

import math
from dataclasses import astuple

import mpmath
import numpy as np
import pytest

from tests.oracle.barrier import barrier

LIMITS = ((1.0, 0.8), (1.5, 1.3), (3.0, 0.5))


def exact_barrier(v, c, u1, u2):
    """(v_c1, v - v_c1, V1, V1/A, q), straight from the printed definitions."""
    with mpmath.workdps(50):
        V, C, U1, U2 = (mpmath.mpf(number) for number in (v, c, u1, u2))
        delta, side = U1 - U2, mpmath.sign(C)
        x = C
        if abs(C) > U2:
            x = side * U2
        if abs(C) > U2 + 1 / delta:
            x = side * (abs(C) + U1 - mpmath.sqrt((abs(C) - U1) ** 2 + 4)) / 2

        def f(speed):
            return -mpmath.log((U1 - abs(speed)) / delta) if abs(speed) > U2 else mpmath.mpf(0)

        V1 = (V - C) ** 2 / 2 + f(V) - (x - C) ** 2 / 2 - f(x)
        A = V - C + (mpmath.sign(V) / (U1 - abs(V)) if abs(V) > U2 else 0)
        return x, V - x, V1, V1 / A, (V - x) / A


def random_points(u1, u2, count):
    """(v, c) in all regions: anywhere, near v_c1, near the kink and near the limit."""
    rng = np.random.default_rng(20)
    dead = u2 + 1.0 / (u1 - u2)
    points = []
    for _ in range(count):
        c = rng.choice([rng.uniform(0, u2), rng.uniform(u2, dead), dead + 10 ** rng.uniform(-6, 3)])
        x = float(exact_barrier(0.1234, c, u1, u2)[0])
        near = rng.choice([-1, 1]) * 10 ** rng.uniform(-12, -1)
        v = rng.choice([rng.uniform(-u1, u1), x + near, u2 + near, -u2 + near, u1 - abs(near)])
        side = rng.choice([-1, 1])
        points.append((side * float(np.clip(v, 1e-6 - u1, u1 - 1e-6)), side * float(c)))
    return points


@pytest.mark.slow
def test_barrier_equals_its_definition_at_50_digits():
    names = ("v_c1", "gap", "V1", "V1/A", "q")
    points = [(u1, u2, *point) for u1, u2 in LIMITS for point in random_points(u1, u2, 1000)]
    for u1, u2, v, c in points:
        expected = exact_barrier(v, c, u1, u2)
        actual = astuple(barrier(v, c, u1, u2))

        for name, found, true in zip(names, actual, expected, strict=True):
            error = abs(found - true)
            assert error <= max(1e-12 * abs(true), 1e-15), (name, u1, u2, v, c, found, true)


@pytest.mark.parametrize("u1, u2", LIMITS)
def test_barrier_pushes_towards_its_minimiser(u1, u2):
    for v, c in random_points(u1, u2, 1000):
        b = barrier(v, c, u1, u2)

        assert b.V1 >= 0.0
        assert 0.0 <= b.q <= 1.0
        assert b.V1_by_A * b.gap >= 0.0
        assert abs(b.V1_by_A) <= abs(b.gap) * (1.0 + 1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("c, q", [(0.3, 1.0), (3.0, 0.0), (7.17, None)])
def test_barrier_has_its_limits_at_the_minimiser(c, q, side):
    x = barrier(0.0, c, 1.0, 0.8).v_c1
    b = barrier(side * x, side * c, 1.0, 0.8)

    assert b.v_c1 == side * x
    assert abs(b.V1_by_A) < 1e-16
    assert b.q == pytest.approx(1.0 / (1.0 + (1.0 - x) ** -2) if q is None else q, abs=1e-15)


def test_border_of_the_saturated_regions_is_decided_exactly():
    u1, u2 = 1.0, 0.5  # 1/delta = 2 and all of these are exact in binary

    assert barrier(0.6, 2.5, u1, u2).v_c1 == 0.5
    assert barrier(0.6, math.nextafter(2.5, 3.0), u1, u2).q > 0.05
    assert barrier(0.5, 2.5, u1, u2).q == 0.0
