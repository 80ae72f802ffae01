"""Trials of the command filter: the page has every statement, and bases that break one are seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks import filter_trials
from tests.filter.adversary import Base, fastest

PAGE = (Path(__file__).parents[2] / "docs" / "filter.md").read_text(encoding="utf-8")


def test_the_page_has_every_statement_with_a_hundred_thousand_trials_and_no_break():
    part = PAGE.partition("<!-- begin trials -->")[2].partition("<!-- end trials -->")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in part.splitlines() if line]
    found = [row[:3] for row in rows[2:]]

    assert found == [[item.title, "100,000", "0"] for item in filter_trials.STATEMENTS]
    assert all(len(row[4].split("),")) == len(item.broken)
               for row, item in zip(rows[2:], filter_trials.STATEMENTS, strict=True))  # fmt: skip
    assert all("(1.0" in row[4] for row in rows[2:])


def test_a_command_that_does_not_keep_the_curvature_is_seen():
    asked = np.array([[3.0, 3.0, -3.0, 0.0, 2.0], [1.0, 1.0, 1.0, 2.0, 1.0], [0.0] * 5])
    sent = np.array([[1.5, 1.5, 1.5, 0.0, -2.0], [0.5, 0.6, -0.5, 1.0, -1.0]])
    off = filter_trials._turned(asked, sent, 2.0**-52)
    assert off.tolist() == [False, True, True, False, True]


@pytest.mark.slow
def test_the_package_is_tried_as_the_graph_is():
    """Both engines of the filter, the same adversary: the same speeds but for rounding."""
    stated = filter_trials.scenario("governor", delay=(0.02, 0.06), losses=1)
    base = Base(delay=(0.02, 0.06), losses=1)
    compiled = filter_trials.Compiled(stated)
    found = [
        fastest(stated, base, 50, 60, 3),
        fastest(stated, base, 50, 60, 3, lambda _, n: compiled.sender(n)),
    ]

    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(filter_trials.STATEMENTS)))
def test_a_few_trials_of_every_statement(number):
    item = filter_trials.STATEMENTS[number]
    broken = list(item.broken.values())[-1]

    assert item.inside(400, 5).max() <= 1.0
    assert broken(400, 6).max() > 1.0
