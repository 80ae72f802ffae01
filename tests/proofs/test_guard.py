"""The velocity guard without lateness, as docs/guarantee.md states it.

M v' = F - F1 + d on each axis, F held over the period T. M is between M_min and M_max and may
change, friction never accelerates, |d| <= dbar, and the measured velocity is within nbar.  Then for
every law a robot inside stays inside, a robot outside comes back, and there is always a safe force.
"""

import pytest

from tests.proofs.anew import altered, assert_proved, claim_of, verdict
from wmr_ctrl.control.guard import guard


def test_there_is_always_a_safe_force():
    """lo(y) <= hi(y) for every measured velocity."""
    assert_proved("guard.feasible")


def test_inside_stays_inside_for_a_whole_period():
    """|v| <= u1 at a sample implies |v| <= u1 until the next, for any requested force."""
    assert_proved("guard.inside")


def test_outside_never_speeds_up_and_comes_back():
    assert_proved("guard.outside")
    assert_proved("guard.return")


def test_flag_feasible_means_that_the_conditions_hold():
    assert_proved("guard.promise")


@pytest.mark.slow
def test_controller_that_is_exported_keeps_the_limit():
    """Law, guard and either map onto the wheels as one graph, while the flag `feasible` is 1."""
    assert_proved("guard.assembled.keeps")
    assert_proved("guard.assembled.controller")


def test_commands_under_way_stay_as_small_as_the_guard_counts():
    """The remembered commands stay within `largest` one sample later, for a constant delay."""
    assert_proved("guard.assembled.carried")


def test_guard_that_forgets_the_push_is_refuted():
    with altered(guard.ceiling, "slope * left - b.net", "slope * left"):
        assert verdict(claim_of("guard.inside")) == "REFUTED"
