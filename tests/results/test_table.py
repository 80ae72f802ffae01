"""Spreads and the table."""

from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.simulation.campaign.synthetic import made_up
from tests.tables import cases
from wmr_ctrl.core.errors import UnknownNameError
from wmr_ctrl.results.table import STATISTICS, RunTable, Spread, spread, table_of_rows
from wmr_ctrl.simulation.campaign.engine import run_campaign
from wmr_ctrl.simulation.campaign.paper_runs import paper_plan

VALUES = st.lists(st.none() | st.floats(-1e6, 1e6), max_size=30)


@pytest.fixture(scope="module")
def campaign():
    with made_up():
        return run_campaign(paper_plan(seeds=2), jobs=1)


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
    assert table.case("paper-simulation", "nn").rows == 2
    assert set(table.case("far-start", "mb").by_seed("ise_total")) == {0, 1}
    assert table.case("paper-simulation", "pid").spread("violated").mean == 1.0
    assert len(table.records()) == table.rows == len(table["seed"])


@pytest.mark.parametrize(
    "figure, scenario, law",
    cases("""
    nothing | paper-simulation | nn
    ise_total | no-scenario | nn
    ise_total | paper-simulation | lqr
    """),
)
def test_unknown_names_are_told(campaign, figure, scenario, law):
    with pytest.raises(UnknownNameError):
        campaign.table.case(scenario, law).by_seed(figure)


def test_rows_become_columns_and_rows_again():
    rows = [
        {"law": "mb", "guard": None, "seed": 3, "outcome": "completed", "ise_total": 1.5},
        {"law": "nn", "guard": True, "seed": 4, "outcome": "diverged", "ise_total": None},
    ]
    table = table_of_rows(rows)

    assert table.records() == rows
    assert table.where(guard=True).records() == table.broken.records() == rows[1:]
    assert table.where(law=None).rows == 2
    assert table.median("ise_total") == 1.5
    assert (RunTable().rows, RunTable().records(), RunTable().different("law")) == (0, [], ())


def test_the_spread_of_two_numbers_is_half_their_distance():
    found = spread([5.0, None, 1.0, float("nan")])

    assert found == Spread(2, 3.0, 1.0, 5.0, 2.0, 4.0, 3.0, 2.0)
