"""Forecasts of a speed: least elements, fading bounds."""

import math

import casadi as ca
import numpy as np
import pytest

from wmr_ctrl.control.filter.forecast import (
    FLATTEST,
    PIECES,
    Fading,
    at_most,
    bounds_after,
    least_of,
    stays_of,
)


@pytest.mark.parametrize("count", [1, 2, 7, 16])
def test_the_least_of_any_number_of_elements_is_found(count):
    values = np.random.default_rng(count).normal(size=count)

    assert float(ca.evalf(least_of(ca.SX(values)))) == values.min()
    assert float(ca.evalf(at_most(ca.SX(values)))) == max(values.min(), 0.0)


@pytest.mark.parametrize("rate, time", [(2.0, 0.0), (2.0, 0.1), (30.0, 1.0)])
def test_what_stays_is_never_less_than_the_exponential(rate, time):
    stays = float(ca.evalf(stays_of(ca.SX(rate), ca.SX(time))))

    assert math.exp(-rate * time) <= stays <= 1 + 1e-11
    for wrong in (-1.0, math.nan):
        assert float(ca.evalf(stays_of(ca.SX(rate), ca.SX(wrong)))) == pytest.approx(1.0)


@pytest.mark.parametrize("came", [1, 0])
def test_an_untimely_sample_makes_all_of_it_past(came):
    before = Fading(ca.SX(0.4), ca.SX(0.2), ca.SX(0.7))
    after = before.aged(ca.SX(came), ca.SX(0.1), ca.SX(0.9), ca.SX(0.5))
    numbers = [float(ca.evalf(item)) for item in (after.reach, after.past, after.held)]

    assert numbers == pytest.approx([0.2, 0.1, 0.7] if came else [0.36, 0.36, 0.1])
    assert float(ca.evalf(before.changed(ca.SX(-2.0), ca.SX(0.5)).reach)) == pytest.approx(1.4)


def test_the_past_leads_no_further_than_the_limit():
    above, below = Fading(ca.SX(0.4), ca.SX(0.3), ca.SX(0.9)).bounds(ca.SX(1.0))

    assert float(ca.evalf(above)) == pytest.approx(0.1, abs=1e-8)
    assert float(ca.evalf(below)) == pytest.approx(0.3)


def test_a_bound_one_period_before_is_the_younger_one_and_no_line_is_flat():
    high = np.random.default_rng(1).normal(size=3 * PIECES)
    high[0] = high[PIECES] + FLATTEST
    younger = [*high[: -PIECES - 1], max(high[-PIECES - 1 :])]
    least = [y if y <= own else max(y, own + 2 * FLATTEST)
             for y, own in zip(younger, high[PIECES:], strict=True)]  # fmt: skip
    found = ca.evalf(bounds_after(ca.SX(high)))
    assert np.array(found).ravel().tolist() == least
