"""Spreads and the table."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmr_ctrl.campaign import STATISTICS, FigureTable, Spread, spread
from wmr_ctrl.errors import UnknownNameError

VALUES = st.lists(st.none() | st.floats(-1e6, 1e6), max_size=30)


@given(values=VALUES)
def test_a_spread_leaves_out_what_is_none_and_is_ordered(values):
    numbers = [value for value in values if value is not None]
    summary = spread(values)

    assert summary.count == len(numbers)
    if numbers:
        assert summary.min == min(numbers)
        assert summary.max == max(numbers)
        assert summary.min <= summary.q25 <= summary.median <= summary.q75 <= summary.max
        assert summary.mean == pytest.approx(np.mean(numbers), abs=1e-9)
    else:
        assert summary == Spread(0)


def test_every_statistic_is_the_field_of_its_name():
    fields = asdict(Spread(3, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0))

    assert {"count": 3, **Spread(*fields.values()).statistics} == fields
    assert tuple(Spread(0).statistics) == STATISTICS


def test_a_table_finds_cases_and_figures(campaign):
    table = campaign.table

    assert table.laws == ("pid", "smc", "mb", "nn")
    assert len(table.case("paper-simulation", "nn")) == 2
    assert set(table.values("ise_total", "far-start", "mb")) == {0, 1}
    assert table.spread("violated", "paper-simulation", "pid").mean == 1.0
    assert len(table) == len(tuple(table))


@pytest.mark.parametrize(
    ("figure", "scenario", "law"),
    [
        ("nothing", "paper-simulation", "nn"),
        ("ise_total", "no-scenario", "nn"),
        ("ise_total", "paper-simulation", "lqr"),
    ],
)
def test_unknown_names_are_told(campaign, figure, scenario, law):
    with pytest.raises(UnknownNameError):
        campaign.table.values(figure, scenario, law)


def test_an_empty_table_has_no_cases():
    assert FigureTable([]).cases == ()
