"""What `reproduce` writes beside the paper: files and sentences, from made-up runs."""

import csv

import pytest

from benchmarks import beyond, guard_runs, tyre_runs
from tests.simulation.campaign.synthetic import made_up
from wmr_ctrl.report.drawing import Drawing


@pytest.mark.parametrize("what", beyond.FILES)
def test_a_comparison_has_a_row_a_run_and_says_what_came_out(what, tmp_path, monkeypatch):
    monkeypatch.setattr(Drawing, "save", lambda drawing, folder: ())
    with made_up():
        beyond.run(what, tmp_path, None, True, None)
    table, words = beyond.FILES[what]
    with (tmp_path / table).open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    seeds = guard_runs.HELD_OUT if what == "ours" else tyre_runs.RIGID_SEEDS

    assert {row[head.index("seed")] for row in rows} == {str(seeds[0])}
    assert all(name.endswith("]") for name in head[6:])
    assert (tmp_path / words).read_text("utf-8").count("\n") >= 2
