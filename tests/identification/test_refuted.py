"""Bounds that the last third of a log contradicts are named; good logs contradict none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.own_plant import log_of, simulate
from tests.identification.conftest import KNOWN, TRUTH
from wmr_ctrl.identification import identify
from wmr_ctrl.identification.refuted import contradictions, explaining

PAUSE = 1.0


def goes_on(driven, **changes):
    """The first robot's log, and after a pause that of the same robot with other numbers."""
    other = simulate(replace(TRUTH, **changes), 1, 12.0, seed=5, step=2e-3)
    first, last = (
        {key: np.array(value) for key, value in log.items()}
        for log in (log_of(driven, 0), log_of(other, 0))
    )
    last["t [s]"] = last["t [s]"] + first["t [s]"][-1] + PAUSE
    for key in ("wheel_counts[1] [1]", "wheel_counts[2] [1]"):
        last[key] = last[key] - last[key][0] + first[key][-1]
    return {key: np.concatenate((first[key], last[key])).tolist() for key in first}


def test_a_good_log_contradicts_none_of_its_bounds(found):
    assert found.bounds.refuted == ()
    assert contradictions(found.white, found.bounds) == ()


def test_a_pause_changes_nothing(driven):
    assert identify(goes_on(driven), overrides=KNOWN).bounds.refuted == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"m": 42.0}, "guard.M_min[1]"),
        ({"I": 2.4}, "guard.M_min[2]"),
        ({"gust": (12.0, 2.4, 0.5)}, "guard.dbar[2]"),
    ],
)
def test_what_changed_in_the_last_third_is_named_and_the_guard_is_off(driven, changes, key):
    found = identify(goes_on(driven, **changes), overrides=KNOWN)

    assert any(key in text for text in found.bounds.refuted), found.bounds.refuted
    assert not found.scenario.guard.enabled
    assert any("the guard is off: the last third" in text for text in found.remarks)


def test_bounds_that_are_too_narrow_are_contradicted_until_dbar_is_wide_enough(found):
    """The monitor's least push: with it as dbar nothing contradicts, with a little less it does."""
    narrow = replace(found.bounds, dbar=(0.01, 0.01))

    against = contradictions(found.white, narrow)
    enough = explaining(found.white, narrow)

    assert {item.axis for item in against} <= {0, 1}
    assert 1 in {item.axis for item in against}
    assert contradictions(found.white, enough) == ()
    for item in against:
        least = [0.0, 0.0]
        least[item.axis] = 0.999 * item.push
        assert item.axis in {
            each.axis for each in contradictions(found.white, replace(narrow, dbar=tuple(least)))
        }
        assert "dbar" in item.against(narrow)
