"""The linear loop against runs from many starts."""

import math

import pytest

from wmr_ctrl.simulation.campaign.against_run import AgainstRun, LawAgainstRun, Parting, _passed


def test_the_size_is_the_last_one_below_the_level_on_a_line_between():
    apart = {0.1: 0.001, 0.2: 0.005, 0.4: 0.02, 0.8: 0.5}
    below, above = _passed(apart, 0.01)

    assert (below, above) == (0.2, 0.4)
    assert _passed({0.1: 0.001}, 0.01)[1] is None


def test_numbers_are_told_by_law_and_direction_and_refusals_by_their_reason():
    none = [0.0]
    parting = Parting("m", none, none, 0.2, math.nan, None, 0.1, none, none)
    law = LawAgainstRun("mb", 20.0, 0.01, (), {"ahead": parting})
    told = AgainstRun("toy", {"mb": law}, {"pid": "no reason."}).to_json()

    assert told["mb"]["ahead"] == {
        "one_per_cent": 0.2, "ten_per_cent": None, "unit": "m", "reason": None,
    }  # fmt: skip
    assert told["pid"] == {"refused": "no reason."}
    with pytest.raises(KeyError):
        _ = told["nn"]
