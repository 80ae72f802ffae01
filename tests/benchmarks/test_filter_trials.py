"""Trials of the command filter: the page has every statement, and bases that break one are seen."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.filter_trials.adversary import Base, fastest
from benchmarks.filter_trials.altered import ALTERED
from benchmarks.filter_trials.compiled import WIDE_TURNS, Compiled, turned
from benchmarks.filter_trials.first_order import BAND, FAST_TURNS, told_of
from benchmarks.filter_trials.linear import RIM_SWUNG, linear
from benchmarks.filter_trials.statements import REFUSED, STATEMENTS, refusals, refused
from benchmarks.filter_trials.stopping import FAMILIES, TEETH
from tests.benchmarks.pages import RESULTS, table


def part(name):
    """Rows of a table that the command writes."""
    return table(RESULTS, name)[1:]


def test_the_page_has_every_statement_and_no_break():
    rows = part("trials")

    assert [row[0] for row in rows] == [item.title for item in STATEMENTS]
    assert all(0.9 < float(row[1]) <= 1 for row in rows)
    assert all(len(row[2].split("),")) == len(item.broken)
               for row, item in zip(rows, STATEMENTS, strict=True))  # fmt: skip
    assert all("(1.0" in row[2] for row in rows)


def test_the_page_has_every_base_that_stops_and_no_break():
    rows = part("stops")

    assert [row[0] for row in rows] == list(FAMILIES)
    assert sum(int(row[1].replace(",", "")) for row in rows) >= 600_000
    assert all(float(row[2].removesuffix(" mm")) >= 0 for row in rows)
    assert all(0.9 < float(row[3].rstrip("%")) / 100 <= 1 for row in rows)


@pytest.mark.parametrize("name, known", [("stops-broken", TEETH), ("stops-altered", ALTERED)])
def test_the_page_has_a_break_of_each_wrong_bound_and_formula(name, known):
    rows = part(name)

    assert [row[0] for row in rows] == list(known)
    assert all(any(row[1:]) for row in rows)


def test_the_page_has_the_words_of_what_is_refused():
    assert refusals() in RESULTS
    assert all(refused(number) for number in range(len(REFUSED)))


def test_a_push_on_omega_beyond_its_bound_is_noticed():
    told = replace(RIM_SWUNG, told={**RIM_SWUNG.told, "d": (0.05, 0.05)})
    assert linear("clip", told, RIM_SWUNG, of="body", changes=WIDE_TURNS)(80, 1).max() > 1


def test_a_command_with_another_curvature_is_noticed():
    asked = np.array([[3.0, 3.0, -3.0, 0.0, 2.0], [1.0, 1.0, 1.0, 2.0, 1.0], [0.0] * 5])
    sent = np.array([[1.5, 1.5, 1.5, 0.0, -2.0], [0.5, 0.6, -0.5, 1.0, -1.0]])
    off = turned(asked, sent, 2.0**-52)
    assert off.tolist() == [False, True, True, False, True]


@pytest.mark.parametrize("share, seen", [(1.0, False), (1.001, True)])
def test_a_least_command_that_does_not_act_is_noticed(share, seen):
    least = {**FAST_TURNS, "filter.least": True}
    stated = told_of("clip", Base(**BAND), least)
    tried = Compiled(stated)
    tried.bands = [(rows, share * np.array(sizes)) for rows, sizes in tried.bands]
    found = fastest(stated, Base(**BAND), 40, 40, 2, lambda _, n: tried.sender(n))

    assert (found.max() > 1) == seen


@pytest.mark.parametrize("number", [0, 5, 7, 11, 12, 13, 18, 28, 32, 33, 36, 37, 41])
@pytest.mark.slow_but("5", "7", "28", "33", "37")
def test_a_few_trials_of_some_statements(number):
    """The last broken hypothesis is tried, or another one if so few trials miss it."""
    item = STATEMENTS[number]

    assert item.inside(400, 5).max() <= 1.0
    assert any(broken(400, 6).max() > 1.0 for broken in reversed(item.broken.values()))
