"""Largest stable control periods: closed forms, the audit's figures, runs on each side."""

import numpy as np
import pytest

from tests.linear.stepper import stepper
from wmr_ctrl.theory.linear import (
    largest_stable_period,
    one_step_period,
)
from wmr_ctrl.world.scenario import override

BELOW, ABOVE = 0.99, 1.01


def grows(scenario, law, period, point=None, memory="frozen", duration=None):
    """Whether a millimetre's displacement is larger at the end of a nonlinear run than before."""
    loop = stepper(scenario, law, point, period, memory)
    s = loop.point.s + 1e-6 * np.array((1.0, 0.0, 1.0, 0.0, 0.0))
    course = loop.run(s, duration or 600 * period)
    apart = np.abs(course.v - loop.point.v).max(axis=1)
    return bool(apart[-20:].max() > apart[:20].max())


def test_model_based_limit_is_the_closed_form_of_its_faster_axis(nominal):
    """e' = -v, v' = rho/2 k e - (rho/2 + k) v held: a pole reaches -1 at T = 2/(rho/2 + k)."""
    found = largest_stable_period(nominal, "mb")

    assert found == pytest.approx(2 / (57.6 / 2 + 4), rel=2e-4)  # the circle couples a little
    assert found == pytest.approx(0.0609, rel=2e-3)


@pytest.mark.parametrize("law", ["pid", "smc", "mb", "nn"])
@pytest.mark.slow_but("mb")
def test_nonlinear_runs_agree_just_below_and_just_above(nominal, law):
    """Without friction, so that every law rests on the reference with its estimates at zero."""
    smooth = override(nominal, {"robot.mu": 0.0})
    limit = largest_stable_period(smooth, law)

    assert not grows(smooth, law, BELOW * limit)
    assert grows(smooth, law, ABOVE * limit)


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


def test_one_step_limit_in_closed_form(nominal):
    """Inside R1 the worst v is -v_u2: (v_u1 + v_u2)/(rho (c + v_u2)/2)."""
    expected = 1.8 / (15 * (0.2 + 0.8) / 2)

    assert one_step_period(nominal, "mb", np.array((0.2, 0.0)))[0] == pytest.approx(expected)


def test_a_law_without_barrier_has_no_one_step_limit(nominal):
    assert one_step_period(nominal, "pid") is None
