"""Tables of many runs: one number a column, the same that a whole Run tells."""

from __future__ import annotations

import numpy as np
import pytest

from wmr_ctrl import simulate, simulate_many
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.simulation.figures import COLUMNS, EVENTS

SHORT = {"clock.duration": 4.0}


@pytest.fixture(scope="module")
def table():
    return simulate_many("far-start", "mb", range(3), SHORT)


def test_columns_are_what_a_run_of_that_seed_says(table):
    for place, seed in enumerate(range(3)):
        said = simulate("far-start", "mb", seed=seed, overrides=SHORT).summary()
        pairs = {
            "violations": said["violations"],
            "position_rms": said["position_rms"]["all"],
            "position_rms_last_quarter": said["position_rms"]["last_quarter"],
            "position_max": said["position_max"],
            "ise_total": said["ise"]["total"],
            "ise_after": said["ise"]["after"],
            "max_abs_v1": said["max_abs_v"][0],
            "max_abs_v2": said["max_abs_v"][1],
            "tau_peak": said["tau_peak"],
            "torque_change_rms": said["torque_change_rms"],
        }
        assert table["outcome"][place] == said["outcome"]
        assert table["tracked"][place] == said["tracked"]
        for name, value in pairs.items():
            assert table[name][place] == pytest.approx(value, rel=1e-9), name


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
