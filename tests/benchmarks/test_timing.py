"""Interleaved timing: order, ratios, refusals."""

from functools import partial

import pytest

from benchmarks import timing
from benchmarks.timing import Candidate, measure, sample, summarize


def two():
    return {"floor": Candidate(list, 1), "slow": Candidate(dict, 1)}


def test_every_candidate_runs_once_a_round_in_rotating_order():
    calls = []
    candidates = {name: Candidate(partial(calls.append, name), 1) for name in "abc"}
    times = sample(candidates, 4)

    assert "".join(calls) == "abc" + "abc" + "bca" + "cab" + "abc"
    assert {len(values) for values in times.values()} == {4}


def test_ratios_are_taken_round_by_round():
    drifting = {"floor": [10.0, 20.0, 40.0], "other": [20.0, 40.0, 80.0]}
    other = summarize(drifting, "floor")["other"]

    assert (other.ratio, other.low, other.high, other.ns) == (2.0, 2.0, 2.0, 40.0)


def test_a_step_costs_what_the_clock_advanced_by_its_number(monkeypatch):
    now = [0]

    def work():
        now[0] += 600

    monkeypatch.setattr(timing, "clock", lambda: now[0])

    assert sample({"worker": Candidate(work, 3)}, 2) == {"worker": [200.0, 200.0]}


def test_too_few_rounds_and_unknown_floors_are_refused():
    with pytest.raises(ValueError, match="at least 9"):
        measure(two(), "floor", rounds=8)
    with pytest.raises(ValueError, match="no candidate is named 'ground'"):
        measure(two(), "ground")
