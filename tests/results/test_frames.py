"""Runs in the types of other libraries: the same numbers under the same names, with units."""

import math

import numpy as np
import pytest

from tests.equal_runs import runs_equal
from tests.results.conftest import build
from wmr_ctrl.results import json_safe, load_run
from wmr_ctrl.results.frames import table_html

pandas = pytest.importorskip("pandas")


def test_a_table_has_every_logged_number_by_its_name():
    run = build(v1=0.3, x=np.arange(100.0))
    frame = run.to_dataframe()

    assert frame.index.name == "t"
    assert list(frame.columns) == [s.name for s in run.elements if s.name != "t"]
    np.testing.assert_array_equal(frame.index, run.time)
    for name in frame.columns:
        np.testing.assert_array_equal(frame[name], run[name])
        assert frame.attrs["units"][name] == run.signal(name).unit


def test_a_run_saves_draws_and_sums_itself_up(tmp_path):
    from wmr_ctrl.results import summary

    run = build(x=0.1)
    run.save(tmp_path / "run.npz")
    figure = run.plot(tmp_path / "run.png")

    assert runs_equal(load_run(tmp_path / "run.npz"), run)
    assert (tmp_path / "run.png").stat().st_size > 10_000
    assert figure.get_size_inches()[0] > 5
    assert run.summary() == summary(run)
    assert summary(run)["watched_every"] == run.settings.plant
    assert run.law in run._repr_html_()
    assert "position error" in run._repr_html_()


def test_cells_cannot_break_out_of_their_table():
    text = table_html("<b>", [("<script>", "&")])

    assert "<script>" not in text
    assert "&lt;script&gt;" in text


@pytest.mark.parametrize(
    "value, plain",
    [
        ([1.5, math.inf], [1.5, None]),
        (np.float64("nan"), None),
        (np.int64(3), 3),
        (np.bool_(True), True),
        (np.array([[1.0, -math.inf]]), [[1.0, None]]),
        ({"a": (1, np.float64(0.5))}, {"a": [1, 0.5]}),
    ],
)
def test_numbers_without_a_json_name_become_null(value, plain):
    assert json_safe(value) == plain
    assert type(json_safe(value)) is type(plain)
