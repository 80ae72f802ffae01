"""The floor's barrier against its definition (10)-(20) at 50 digits."""

from functools import cache

import mpmath as mp
import numpy as np
import pytest

from benchmarks.hand_c import HandC
from benchmarks.native import floor_toolchain
from benchmarks.setup import Setup
from wmr_ctrl.core.errors import CompilerError

try:
    floor_toolchain()
except CompilerError as missing:
    pytest.skip(str(missing), allow_module_level=True)

mp.mp.dps = 50
SETUP = Setup()
TOP = [limit - SETUP.clip for limit in SETUP.v_u1]


@cache
def hand():
    return HandC()


def exact(axis, v, c):
    """v - v_c1, V1/A and q as the paper prints them; v must not equal v_c1."""
    u1, u2, v, c = (mp.mpf(n) for n in (SETUP.v_u1[axis], SETUP.v_u2[axis], v, c))
    x = target(u1, u2, c)
    V = (v - c) ** 2 / 2 + barrier_f(u1, u2, v) - (x - c) ** 2 / 2 - barrier_f(u1, u2, x)
    A = v - c + (mp.sign(v) / (u1 - abs(v)) if abs(v) > u2 else 0)
    return v - x, V / A, (v - x) / A


def target(u1, u2, c):
    if abs(c) <= u2:
        return c
    if abs(c) <= u2 + 1 / (u1 - u2):
        return mp.sign(c) * u2
    return mp.sign(c) * (abs(c) + u1 - mp.sqrt((abs(c) - u1) ** 2 + 4)) / 2


def barrier_f(u1, u2, v):
    return -mp.log((u1 - abs(v)) / (u1 - u2)) if abs(v) > u2 else mp.mpf(0)


def assert_exact(axis, v, c):
    for name, expected, actual in zip(
        ("w", "V1/A", "q"), exact(axis, v, c), hand().barrier(axis, v, c), strict=True
    ):
        slack = max(mp.mpf(1e-12) * abs(expected), mp.mpf(1e-15))

        assert abs(mp.mpf(float(actual)) - expected) <= slack, (name, axis, v, c, float(expected))


@pytest.mark.parametrize("region, axis", [(1, 0), (2, 1), (3, 1)])
@pytest.mark.slow_but("3-1")
def test_barrier_is_exact_in_every_region(region, axis):
    rng, u2 = np.random.default_rng(10 * region + axis), SETUP.v_u2[axis]
    edge = u2 + 1 / (SETUP.v_u1[axis] - u2)
    bounds = [(1e-9, u2), (u2 * (1 + 1e-9), edge * (1 - 1e-9)), (edge * (1 + 1e-9), 1e6)]
    low, high = bounds[region - 1]
    for _ in range(1500):
        c = np.exp(rng.uniform(np.log(low), np.log(high))) * rng.choice([-1, 1])
        assert_exact(axis, rng.uniform(-TOP[axis], TOP[axis]), c)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.slow_but("1")
def test_barrier_is_exact_close_to_its_target(axis):
    rng = np.random.default_rng(20 + axis)
    for _ in range(1500):
        c = np.exp(rng.uniform(np.log(0.1), np.log(50.0))) * rng.choice([-1, 1])
        x = float(target(*(mp.mpf(n) for n in (SETUP.v_u1[axis], SETUP.v_u2[axis], c))))
        v = x + 10.0 ** rng.uniform(-9, -1) * rng.choice([-1, 1])
        if abs(v) < TOP[axis] and v != x:
            assert_exact(axis, v, c)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_barrier_is_exact_on_the_kink_and_on_the_first_boundary(axis, sign):
    u2 = SETUP.v_u2[axis]
    for v in (u2, np.nextafter(u2, 0), np.nextafter(u2, 9), -u2, TOP[axis], -TOP[axis], 0.0):
        for c in (0.3, 3.0, 7.17, 1e4):
            assert_exact(axis, v, sign * c)
    for c in (u2, np.nextafter(u2, 0), np.nextafter(u2, 9)):
        assert_exact(axis, 0.5, sign * c)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_limits_at_the_target(axis, sign):
    u1, u2 = SETUP.v_u1[axis], SETUP.v_u2[axis]
    v = 0.9375 * u1
    d = u1 - v  # exact, so v is the target of the v_c0 below up to its rounding
    c = v + 1 / d
    cases = {0.25: (0.25, 1.0), 3.0: (u2, 0.0), c: (v, 1 / (1 + 1 / d**2))}
    for c_here, (v_here, q) in cases.items():
        found = hand().barrier(axis, sign * v_here, sign * c_here)

        np.testing.assert_allclose(found[:2], 0.0, atol=1e-15)
        np.testing.assert_allclose(found[2], q, rtol=1e-12)


def test_barrier_is_never_nan_for_v_c0_up_to_1e150():
    speeds = [0.0, -0.0, 5e-324, 0.8, 1.3, 1.0, 1.5, 1e308, float("inf")]
    sizes = [0.0, -0.0, 5e-324, 0.8, 1.3, 5.8, 6.3, 1e3, 1e6, 1e100, 1e150]
    for axis in (0, 1):
        for v in speeds:
            for c in sizes:
                for s, z in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                    assert np.isfinite(hand().barrier(axis, s * v, z * c)).all(), (axis, v, c)
