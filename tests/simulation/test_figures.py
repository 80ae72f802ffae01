"""Tables of many runs: one number a column."""

import numpy as np
import pytest

from wmr_ctrl import simulate_many
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.simulation.figures import COLUMNS, EVENTS

SHORT = {"clock.duration": 4.0}


@pytest.fixture(scope="module")
def table():
    return simulate_many("far-start", "mb", range(3), SHORT)


def test_each_column_of_numbers_is_a_figure_or_an_event(table):
    assert len(set(COLUMNS)) == len(COLUMNS)
    assert set(table) == {"seed", "outcome", "tracked", *COLUMNS}
    assert set(COLUMNS) <= {figure.name for figure in FIGURES} | set(EVENTS)
    assert all(column.shape == (3,) for column in table.values())


def test_a_table_goes_on_into_pandas(table):
    pytest.importorskip("pandas")
    frame = table.to_dataframe()

    assert len(frame) == table.rows == 3
    np.testing.assert_array_equal(frame["max_abs_v2"], table["max_abs_v2"])
    assert frame.attrs["units"]["max_abs_v2"] == "rad/s"
    assert "3 runs" in table._repr_html_()
