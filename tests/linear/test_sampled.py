"""Largest stable control periods: closed forms, the audit's figures, runs on each side."""

import numpy as np
import pytest

from wmr_ctrl.theory.linear import largest_stable_period, one_step_period


def test_model_based_limit_is_the_closed_form_of_its_faster_axis(nominal):
    """For e' = -v and the held v' = rho/2 k e - (rho/2 + k) v a pole reaches -1 at T = 2/(rho/2 +
    k).
    """
    # the circle couples a little
    assert largest_stable_period(nominal, "mb") == pytest.approx(2 / (57.6 / 2 + 4), rel=2e-4)


@pytest.mark.parametrize(
    "axis, v_c0, expected",
    [
        (0, 0.2, 0.24), (0, 2.0, 0.1035), (0, 5.8, 0.0853), (0, 7.17, 0.0831),
        (1, 0.2, 0.0648), (1, 2.0, 0.0295), (1, 5.8, 0.0225), (1, 20.0, 0.0194),
    ],
)  # fmt: skip
def test_one_step_limits_of_the_audit(nominal, axis, v_c0, expected):
    asked = np.zeros(2)
    asked[axis] = v_c0

    assert one_step_period(nominal, "mb", asked)[axis] == pytest.approx(expected, rel=5e-3)


def test_a_law_without_barrier_has_no_one_step_limit(nominal):
    assert one_step_period(nominal, "pid") is None
