"""Tables of many runs: one number a column, equal to figures of whole runs."""

import numpy as np
import pytest

from tests.tables import changes
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


@pytest.mark.parametrize(
    "law, guard, told",
    [
        ("prox", True, "disturbance.truncate = 3.0"),
        pytest.param("mb", None, "clock.control = 0.1", marks=pytest.mark.slow),  # beyond limits
    ],
)
def test_every_figure_is_that_of_the_sums(law, guard, told):
    short = changes(f"clock.duration = 6.0; {told}")
    chosen = {"seeds": range(2), "overrides": short, "guard": guard}
    table = simulate_many("far-start", law, **chosen)
    for k, run in enumerate(simulate_runs("far-start", law, **chosen)):
        taken = figures_from_run(run, tuple(table[f"final_{name}"][k] for name, _ in STATE))
        assert taken.keys() == set(COLUMNS)
        for name, value in taken.items():
            known = np.nan if value is None else value
            assert known == pytest.approx(table[name][k], rel=1e-9, nan_ok=True), name
    assert np.isfinite(table["ise_total"]).all()
