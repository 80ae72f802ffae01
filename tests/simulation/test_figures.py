"""Tables of many runs: one number a column, equal to figures of whole runs."""

import numpy as np
import pytest

from wmr_ctrl import simulate_many, simulate_runs
from wmr_ctrl.results.figures import FIGURES, STATE
from wmr_ctrl.simulation.figures import COLUMNS, EVENTS
from wmr_ctrl.simulation.physics.run import figures_from_run

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


@pytest.mark.parametrize(
    "law, overrides, guard",
    [
        ("mb", {"clock.duration": 6.0}, None),
        ("prox", {"clock.duration": 6.0, "disturbance.truncate": 3.0}, True),
        ("mb", {"clock.duration": 6.0, "clock.control": 0.1}, None),  # breaks the limit
    ],
)
@pytest.mark.slow_but("prox-overrides1-True")
def test_every_figure_is_that_of_the_sums(law, overrides, guard):
    chosen = {"seeds": range(2), "overrides": overrides, "guard": guard}
    table = simulate_many("far-start", law, **chosen)
    for k, run in enumerate(simulate_runs("far-start", law, **chosen)):
        taken = figures_from_run(run, tuple(table[f"final_{name}"][k] for name, _ in STATE))
        assert taken.keys() == set(COLUMNS)
        for name, value in taken.items():
            known = np.nan if value is None else value
            assert known == pytest.approx(table[name][k], rel=1e-9, nan_ok=True), name
    assert np.isfinite(table["ise_total"]).all()
