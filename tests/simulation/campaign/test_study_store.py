"""A study's folder: its contents, and the plan and code of its results."""

import numpy as np
import pytest

from tests.simulation.campaign.studies import FACTS, PLAN, plan_of
from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.simulation.campaign.study_store import (
    counted_reasons,
    described_columns,
    finished_study,
    opened,
)


def test_reasons_that_differ_in_numbers_are_one():
    texts = ["a = 1 is above 2.5", "", "b", "a = 3 is above 2.5", "b", "b"]

    assert counted_reasons(texts) == {"b": 3, "a = 1 is above 2.5": 2}
    assert list(counted_reasons(texts)) == ["b", "a = 1 is above 2.5"]


def test_rows_come_back_and_damaged_ones_are_none(tmp_path):
    plan = plan_of(PLAN)
    with opened(tmp_path / "study", plan, FACTS) as folder:
        path = folder.chunk_path(0, [3, 4, 9])
        rows = {name: np.arange(3.0) for name in folder.members}
        folder.keep(path, rows)

        assert np.array_equal(folder.rows(path)["index"], rows["index"])
        folder.keep(path, {"index": rows["index"]})
        assert folder.rows(path) is None
        path.write_bytes(b"no archive")
        assert folder.rows(path) is None
        with pytest.raises(ResultFileError, match="another process is working on this study"):
            opened(tmp_path / "study", plan, FACTS).__enter__()
    assert "seed" in {name for name, _, _ in described_columns(plan)}


def test_a_folder_holds_one_plan_by_one_code(tmp_path):
    with opened(tmp_path, plan_of(PLAN), FACTS):
        pass
    with (
        pytest.raises(ResultFileError, match="was started with other code"),
        opened(tmp_path, plan_of(PLAN), dict.fromkeys(FACTS, "other")),
    ):
        pass
    with (
        pytest.raises(ResultFileError, match="holds the results of another plan"),
        opened(tmp_path, plan_of({**PLAN, "seeds": 999}), FACTS),
    ):
        pass


def test_what_is_no_finished_study_is_named(tmp_path):
    with pytest.raises(ResultFileError, match=r"table\.csv cannot"), finished_study(tmp_path):
        (tmp_path / "table.csv").read_text()
