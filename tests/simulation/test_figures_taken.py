"""Figures taken from a whole Run are those that the lanes' loop adds up."""

import numpy as np
import pytest

from wmr_ctrl import simulate_many, simulate_runs
from wmr_ctrl.results.figures import STATE
from wmr_ctrl.simulation.figures import COLUMNS
from wmr_ctrl.simulation.physics.run import figures_from_run


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
