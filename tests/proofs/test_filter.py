"""The command filter's step for bases that take velocities, as its page states it.

tau v' = K u + d - v on each axis, with tau, K and d anywhere within their bounds at every instant.
The clip sends commands that cannot exceed the limit V together with any earlier ones.  The governor
keeps a bound of the speed, and sends commands under which |v| <= V.
"""

import pytest

from tests.proofs.anew import altered, assert_proved, claim_of, verdict
from wmr_ctrl.control.filter import governor


def test_clip_sends_what_any_linear_loop_may_add_up():
    """The clip keeps N |u| + delta <= V, with the peak gain N and the effect delta of pushes."""
    assert_proved("filter.sent-clip")


def test_least_commands_act_and_are_as_safe_as_others():
    assert_proved("filter.least")


@pytest.mark.slow
def test_clip_of_first_order_bases_keeps_the_limit_from_sample_to_sample():
    """The whole clip: every limited speed, and each way to scale."""
    assert_proved("filter.clip")


def test_governor_sends_at_most_its_limit():
    """The entry covers the whole filter: both axes, any command, with or without odometry."""
    assert_proved("filter.sent")


def test_base_stays_inside_behind_what_the_governor_admits():
    assert_proved("filter.assembled")


@pytest.mark.slow
def test_bound_that_the_governor_keeps_is_a_bound_a_step_later():
    assert_proved("filter.carried")


def test_governor_keeps_speed_and_bound_from_sample_to_sample():
    """One entry covers the command, the speed and the memory."""
    assert_proved("filter.step")


def test_governor_that_forgets_the_push_is_refuted():
    with altered(governor.largest_command, "(b.V - b.dbar)", "b.V"):
        assert verdict(claim_of("filter.inside")) == "REFUTED"
