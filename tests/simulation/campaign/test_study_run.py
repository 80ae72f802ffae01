"""Studies: the same bytes for any executor and any interruptions; correct stops."""

import csv
import json
import math
from collections import Counter

import numpy as np
import pytest

import wmr_ctrl
from tests.simulation.campaign.studies import FACTS, PLAN, REAL, figures, refuse_after, table_of
from wmr_ctrl import simulate
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.simulation.campaign.study_plan import plan_of
from wmr_ctrl.simulation.campaign.study_run import run_study

# -- the same bytes ------------------------------------------------------------------------


@pytest.mark.parametrize("longest", [7, 59, 60])
def test_chunks_hold_every_run_once_are_nearly_as_long_and_the_table_is_the_same(tmp_path, longest):
    made = []

    def make(chunk, jobs=None):
        made.append(len(chunk.runs))
        return figures(chunk)

    result = run_study(plan_of({**PLAN, "chunk": longest}), tmp_path / "a", make, FACTS)

    assert result.table.read_bytes() == table_of(tmp_path / "b")
    assert sum(made) == plan_of(PLAN).runs
    assert len(made) == math.ceil(sum(made) / longest)
    assert max(made) - min(made) <= 1


@pytest.mark.parametrize("error", [KeyboardInterrupt(), RuntimeError("lost worker")])
def test_an_interrupted_study_goes_on_without_a_lost_or_doubled_run(tmp_path, error):
    plan, made, shares = plan_of(PLAN), [], []
    for count in (0, 2, 5):
        with pytest.raises(type(error)):
            run_study(plan, tmp_path / "a", refuse_after(count, error), FACTS)

    def make(chunk, jobs=None):
        made.append(len(chunk.runs))
        return figures(chunk)

    kept = [int(path.stem.split("-")[-1]) for path in (tmp_path / "a" / "chunks").iterdir()]
    run_study(plan, tmp_path / "a", make, FACTS, progress=shares.append)
    assert shares[-1] == 1.0
    assert len(kept) == 7
    assert sum(made) == plan.runs - sum(kept)
    assert (tmp_path / "a" / "table.csv").read_bytes() == table_of(tmp_path / "b")


# -- stopping ------------------------------------------------------------------------------


def test_a_rule_stops_each_case_at_a_look_and_says_so(tmp_path):
    stop = {"figure": "violated", "half_width": 0.2, "first": 8}
    plan = plan_of({**PLAN, "seeds": 400, "stop": stop, "chunk": 50})
    result = run_study(plan, tmp_path / "a", figures, FACTS)
    rows = list(csv.DictReader(result.table.read_text().splitlines()))
    counts = Counter(int(row["index"]) // 400 for row in rows)

    assert set(counts.values()) <= {8, 16, 32, 64, 128, 256, 400}
    assert result.runs == len(rows) < plan.runs
    assert result.stopped == plan.cells
    assert [int(row["index"]) for row in rows] == sorted(int(row["index"]) for row in rows)
    with pytest.raises(KeyboardInterrupt):
        run_study(plan, tmp_path / "b", refuse_after(3, KeyboardInterrupt()), FACTS)
    again = run_study(plan, tmp_path / "b", figures, FACTS)
    assert again.table.read_bytes() == result.table.read_bytes()


# -- the real thing ------------------------------------------------------------------------


def test_rows_are_the_runs_that_they_name(tmp_path):
    result = wmr_ctrl.study(REAL, tmp_path / "s")
    rows = list(csv.DictReader(result.table.read_text().splitlines()))

    assert len(rows) == 8
    for row in rows:
        guard, torque = row["guard"] == "true", float(row["actuator.tau_max"])
        if guard and torque == 1.0:
            assert (row["outcome"], row["max_abs_v1"]) == ("refused", "")
            assert "tau_max >= 6 N m on (now 1)" in row["refusal"]
            continue
        assert row["refusal"] == ""
        overrides = {**REAL["set"], "actuator.tau_max": torque}
        run = simulate("far-start", "mb", seed=int(row["seed"]), guard=guard, overrides=overrides)
        assert row["outcome"] == run.outcome.value
        assert float(row["max_abs_v1"]) == run.monitor.max_abs_v[0]
        assert float(row["position_rms"]) == pytest.approx(run.summary()["position_rms"]["all"])
        assert float(row["d_start"]) == pytest.approx(np.hypot(5, 5))
    told = json.loads((tmp_path / "s" / "study.json").read_text())
    assert told["provenance"]["version"] == wmr_ctrl.__version__
    ((reason, count),) = result.refused.items()
    assert (count, result.all_refused) == (2, False)
    assert f"2 refused: {reason}" in str(result)


def test_an_error_that_does_not_depend_on_the_guard_is_raised(tmp_path):
    """Runs with and without the guard end with the same message."""
    wrong = {**REAL, "grid": {"clock.control": [0.0105]}}
    told = []
    for guard in (True, False):
        with pytest.raises(ScenarioError) as refused:
            wmr_ctrl.study({**wrong, "guard": [guard]}, tmp_path / str(guard))
        told.append(str(refused.value))

    assert told[0] == told[1]
    assert "clock.plant" in told[0]
