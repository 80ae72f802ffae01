"""Logs of own bases, as the benchmark of `identify` scores them: two fast, all kinds slow."""

import pytest

from benchmarks.base_kinds import BAD, GOOD, KINDS, first_seed
from benchmarks.identify import scored, summary


def test_most_kinds_have_faults_and_all_have_names_of_their_own():
    assert (len(GOOD), len(BAD), len(KINDS)) == (12, 25, 37)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*GOOD, *BAD])
def test_no_kind_breaks_a_limit(kind):
    score = scored(kind, first_seed(kind))

    assert max(score.largest or 0.0, score.largest_beyond or 0.0) <= 1.0
    assert kind in BAD or not score.accused
    if kind == "first":
        assert (score.determined, score.missed, score.told) == (6, [], [])
        assert 0.5 < score.held < score.largest
    if kind == "ramps apart":
        assert {name.split(" ")[0] for name in score.told} == {"decel"}
        told = summary([score])
        assert (told["missed"], told["broken"], told["driven"], told["logs"]) == (0.0, 0, 1, 1)
