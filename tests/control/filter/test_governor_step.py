"""The governor's times, and those that span too many samples."""

import pytest

from tests.control.filter.test_filter import scenario
from wmr_ctrl.control.filter.governor_step import check_jitter, contradiction, schedules
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import override


def test_times_are_counted_in_control_periods():
    T = scenario().clock.control
    base = override(scenario(), {"filter.delay": [T, 3 * T], "filter.losses": 2})

    plans = schedules(base)
    assert [(plan.delay, plan.losses) for plan in plans] == [((1.0, 3.0), 2)] * 2


def test_what_spans_too_many_periods_or_jitters_by_one_is_refused():
    T = scenario().clock.control
    with pytest.raises(ScenarioError, match="the governor handles at most"):
        schedules(override(scenario(), {"filter.delay": [0.0, 200 * T]}))
    with pytest.raises(ScenarioError, match=r"filter\.jitter = .* must be less than the period"):
        check_jitter(override(scenario(), {"filter.jitter": T}))
    assert 0 < contradiction(1.0) < 1e-4
