"""The stable barrier forms against their definition at 50 digits."""

import math
import random

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wmr_ctrl.control.barrier.stable import stable_barrier, stable_minimiser

LIMITS = ((1.0, 0.8), (1.5, 1.3), (0.7, 0.1), (3.0, 1.2), (1.0, 0.99))


def _functions():
    """V1/A, q, v_c1, V1; and the derivatives of the first two by c and v."""
    given = c, v, *_ = [ca.SX.sym(name) for name in ("c", "v", "u1", "u2")]
    found = stable_barrier(*given)
    pair = found.V1_over_A, found.q
    slopes = ca.jacobian(ca.vertcat(*pair), ca.vertcat(c, v))
    return ca.Function("barrier", given, [*pair, found.v_c1, found.V1]), ca.Function(
        "slopes", given, [slopes]
    )


STABLE, SLOPES = _functions()


def exact(c, v, u1, u2):
    """(V1/A, q, v_c1, V1) from Eqs. (10)-(20) as printed, with their limits at v = v_c1."""
    c, v, u1, u2 = map(mp.mpf, (c, v, u1, u2))
    s = 1 if c >= 0 else -1
    c, v = s * c, s * v
    delta = u1 - u2
    x = c if c <= u2 else u2 if c <= u2 + 1 / delta else (c + u1 - mp.sqrt((c - u1) ** 2 + 4)) / 2

    def f(speed):
        return -mp.log((u1 - abs(speed)) / delta) if abs(speed) > u2 else mp.mpf(0)

    value = (v - c) ** 2 / 2 + f(v) - (x - c) ** 2 / 2 - f(x)
    a = v - c + (mp.sign(v) / (u1 - abs(v)) if abs(v) > u2 else 0)
    if v == x:
        q = 1 if c <= u2 else 0 if c <= u2 + 1 / delta else 1 / (1 + 1 / (u1 - x) ** 2)
        return mp.mpf(0), mp.mpf(q), s * x, mp.mpf(0)
    return s * value / a, (v - x) / a, s * x, value


def close(found, wanted):
    """Right to 1e-12 relative or 1e-15 absolute."""
    error = abs(mp.mpf(found) - wanted)
    return bool(error <= mp.mpf("1e-15") or error <= mp.mpf("1e-12") * abs(wanted))


def points(u1, u2, count, off=0.0):
    """(c, v) over all regions, both signs, both sides of every boundary down to one ulp.

    ``off``: least distance from the jumps of q.
    """
    draw = random.Random(f"{u1} {u2}")
    edge = u2 + 1 / (u1 - u2)

    def near(value):
        return value + draw.choice((-1, 0, 1)) * 10 ** draw.uniform(-17, -1)

    found = []
    while len(found) < count:
        c = draw.choice(
            (
                draw.uniform(0, u2),
                draw.uniform(u2, edge),
                draw.uniform(edge, 4 * edge),
                10 ** draw.uniform(-3, 6),
                near(u2),
                near(edge),
                0.0,
                u2,
                edge,
                math.nextafter(edge, 0),
                math.nextafter(edge, 1e9),
                math.nextafter(u2, 9),
            )
        )
        target = float(exact(c, 0, u1, u2)[2])
        v = draw.choice(
            (
                draw.uniform(-u1, u1),
                near(target),
                target,
                near(u2),
                near(-u2),
                math.nextafter(u2, 9),
                0.0,
                u1 - 1e-6,
                1e-6 - u1,
                draw.choice((-1, 1)) * (u1 - 10 ** draw.uniform(-6, -1)),
            )
        )
        if abs(v) <= u1 - 1e-6 and abs(c - edge) >= off:
            found.append(draw.choice(((c, v), (-c, -v))))
    return found


def test_stable_forms_are_right_to_50_digits():
    with mp.workdps(50):
        for u1, u2 in LIMITS:
            for c, v in points(u1, u2, 120):
                wanted = exact(c, v, u1, u2)

                found = [float(number) for number in STABLE(c, v, u1, u2)]

                assert all(map(close, found, wanted)), (u1, u2, c, v, found, wanted)


@pytest.mark.parametrize("u1, u2", LIMITS[:2])
def test_derivatives_are_finite(u1, u2):
    """Derivatives are finite on kinks and region boundaries, too."""
    with mp.workdps(50):
        for c, v in points(u1, u2, 300):
            assert np.isfinite(SLOPES(c, v, u1, u2).full()).all(), (c, v)


C = ca.SX.sym("c")
MINIMISER = ca.Function("x", [C], [stable_minimiser(C, ca.SX(1.0), ca.SX(0.8))])
target = st.floats(-1e6, 1e6)


@given(target, target)
@settings(max_examples=3 * settings.default.max_examples // 2)
def test_minimiser_is_monotone_and_nonexpansive(a, b):
    low, high = sorted((a, b))

    rise = float(MINIMISER(high)) - float(MINIMISER(low))

    assert -1e-15 <= rise <= (high - low) * (1 + 1e-12) + 1e-15


@pytest.mark.parametrize("c", [1e200, -1e308, 5e-324, -0.0, math.inf, -math.inf])
@pytest.mark.parametrize("v", [0.0, -0.0, 5e-324, 0.999999, -0.999999, 0.8, -0.8])
def test_hostile_values_give_no_nan(c, v):
    found = [float(item) for item in STABLE(c, v, 1.0, 0.8)]

    assert not any(map(math.isnan, found)), found
    assert 0.0 <= found[1] <= 1.0
