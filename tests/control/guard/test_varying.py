"""Weights of commands behind a lag that varies."""

from fractions import Fraction as Q

import numpy as np
import pytest

from wmr_ctrl.control.guard.varying import less, ramp, varying


@pytest.mark.parametrize("tau", [None, Q(1, 3), Q(2)])
def test_an_integral_of_the_ramp_is_that_of_its_curve(tau):
    """P is 1 up to an age of 1/2 and falls to 0 over the next 2 periods."""
    begin, end = Q(9, 4), Q(1, 4)
    s = np.linspace(float(end), float(begin), 200_001)
    curve = np.clip(1 - (s - 0.5) / 2, 0, 1)
    curve = curve if tau is None else curve * np.exp(-(float(begin) - s) / float(tau))

    of = ramp(Q(1, 2), Q(2))
    assert float(of(begin, end, tau)) == pytest.approx(np.trapezoid(curve, s), rel=1e-8)
    assert float(less(of, of)(begin, end, tau)) == 0.0
    assert float(of(Q(1), Q(1), tau)) == 0.0


def test_pieces_cover_the_time_of_the_commands_without_a_gap():
    of = ramp(Q(1, 2), Q(0))
    found = varying(2, (Q(1, 4), Q(1, 2)), (Q(1, 5), Q(1, 2)), of, of)

    assert [piece.which for piece in found.pieces] == [(2,), (2, 1), (1,)]
    assert found.longest == 0.5
    lasting = [-np.log(piece.stays[0]) * 0.5 for piece in found.pieces]
    assert sum(lasting) == pytest.approx(2 - 0.25)
    assert found.stays == pytest.approx((np.exp(-0.5), np.exp(-1.25)))
