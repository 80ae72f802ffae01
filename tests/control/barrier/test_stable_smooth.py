"""The barrier with a continuous slope, against its definition in 60 digits."""

import casadi as ca
import mpmath as mp
import numpy as np
import pytest

from tests.control.laws.points import assert_twin
from wmr_ctrl.control.barrier.stable import SERIES_BELOW, _chi, smooth_barrier

U1, U2 = 1.0, 0.8
c, v = ca.SX.sym("c"), ca.SX.sym("v")
_B = smooth_barrier(c, v, ca.SX(U1), ca.SX(U2))
ALL = ca.Function("all", [c, v], [_B.v_c1, _B.w, _B.V1, _B.V1_over_A, _B.q])


def defined(here, speed):
    """v_c1, w, V1, V1/A, q straight from f."""
    u1, u2 = mp.mpf(U1), mp.mpf(U2)
    delta = u1 - u2

    def f(x):
        size = abs(x)
        return -mp.log((u1 - size) / delta) - (size - u2) / delta if size > u2 else mp.mpf(0)

    def slope(x):
        size = abs(x)
        rise = (size - u2) / (delta * (u1 - size)) if size > u2 else mp.mpf(0)
        return mp.sign(x) * rise

    here, speed = mp.mpf(here), mp.mpf(speed)
    t = abs(here) + 1 / delta - u1
    far = u1 - (mp.sqrt(t * t + 4) - t) / 2
    x = here if abs(here) <= u2 else mp.sign(here) * far
    value = (speed - here) ** 2 / 2 + f(speed) - (x - here) ** 2 / 2 - f(x)
    A = speed - here + slope(speed)
    return x, speed - x, value, value / A, (speed - x) / A


def samples():
    draw = np.random.default_rng(0)
    many = [(draw.normal() * 10 ** draw.uniform(-3, 3), draw.uniform(-1, 1)) for _ in range(400)]
    edges = [
        (a + b, d)
        for a in (0.8, -0.8, 0.0)
        for b in (0.0, 1e-12, 1e-3)
        for d in (0.8, 0.8 + 1e-9, -0.85, 0.999999, 0.0)
    ]
    return [*many, *edges]


def test_agrees_with_its_definition_in_60_digits():
    with mp.workdps(60):
        for here, speed in samples():
            if speed == here:
                continue
            found = [float(item) for item in ALL(here, speed)]
            for name, ours, exact in zip(
                ("v_c1", "w", "V1", "V1/A", "q"), found, defined(here, speed), strict=True
            ):
                wanted = float(exact)
                assert ours == pytest.approx(wanted, rel=2e-10, abs=1e-13), (here, speed, name)


@pytest.mark.parametrize("sign", [1, -1])
def test_what_stands_beside_a_logarithm_is_right_to_the_last_digits(sign):
    """(-ln(1 - y) - y)/y, by series where the logarithm would lose more than a digit or two."""
    y = ca.SX.sym("y")
    found = ca.Function("chi", [y], [_chi(y, 1 - y)])
    for size, digits in ((1e-9, 15.4), (0.01, 15.4), (0.99, 15.4), (1.01, 13.5)):
        here = sign * size * SERIES_BELOW
        with mp.workdps(60):
            exact = (-mp.log(1 - mp.mpf(here)) - mp.mpf(here)) / mp.mpf(here)
        assert float(found(here)) == pytest.approx(float(exact), rel=10**-digits, abs=0.0)


@pytest.mark.parametrize("law", ["mb", "nn"])
@pytest.mark.slow_but("mb")
def test_laws_take_it_as_their_twins_do(law):
    assert_twin(law, **{f"gains.{law}.barrier": "smooth"})
