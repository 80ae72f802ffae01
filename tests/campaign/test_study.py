"""Studies: the same bytes whoever runs them, however often they are interrupted; honest stops."""

from __future__ import annotations

import csv
import errno
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import wmr_ctrl
from wmr_ctrl import simulate
from wmr_ctrl.campaign.study_plan import load_plan, plan_of
from wmr_ctrl.campaign.study_run import run_study
from wmr_ctrl.campaign.study_store import counted_reasons, opened
from wmr_ctrl.corridor import find_corridor
from wmr_ctrl.errors import ArgumentError, ResultFileError, ScenarioError, UnknownNameError
from wmr_ctrl.scenario import load_scenario

FACTS = {"version": "1", "kernels": "ab"}
PLAN = {
    "laws": ["mb", "prox"],
    "guard": [False, True],
    "seeds": {"first": 3, "count": 5},
    "grid": {"robot.m": [40, 50.5]},
    "sample": {"method": "latin-hypercube", "n": 3, "robot": {"mu": [0.05, 0.1]}},
    "figures": ["violated", "position_rms", "ise_total"],
    "chunk": 7,
}


def figures(chunk, jobs=None):
    """Numbers that depend on the case and the seed alone; now and then none."""
    rows = []
    for case, seed in chunk.runs:
        mass, mu = case.overrides["robot.m"], case.overrides["robot.mu"]
        broken = float((seed * 7 + int(mass) + case.guard) % 3 == 0)
        rows.append((broken, mass * mu / (seed + 1), np.nan if seed == 4 else 1 / 3 + seed))
    table = np.array(rows).T
    named = dict(zip(("violated", "position_rms", "ise_total"), table, strict=True))
    outcome, refusal = np.array(["completed"] * len(rows)), np.array([""] * len(rows))
    return {"outcome": outcome, "refusal": refusal, **named}


def table_of(out, **changes):
    plan = plan_of({**PLAN, **changes})
    return run_study(plan, out, figures, FACTS).table.read_bytes()


def refuse_after(count, error):
    """Makes so many chunks and then fails."""
    left = [count]

    def make(chunk, jobs=None):
        if left[0] == 0:
            raise error
        left[0] -= 1
        return figures(chunk)

    return make


# -- what a plan means --------------------------------------------------------------------


def test_every_combination_has_one_row_in_the_order_of_the_index(tmp_path):
    rows = list(csv.DictReader(table_of(tmp_path / "s").decode().splitlines()))

    assert [int(row["index"]) for row in rows] == list(range(2 * 3 * 2 * 2 * 5))
    named = ("robot.m", "robot.mu", "law", "guard", "seed")
    assert len({tuple(row[key] for key in named) for row in rows}) == len(rows)
    assert list(rows[0])[:7] == ["index", "law", "guard", "seed", "robot.m", "robot.mu", "outcome"]
    assert {row["ise_total"] for row in rows if row["seed"] == "4"} == {""}


def test_a_latin_hypercube_has_one_point_in_each_stratum():
    sample = plan_of(
        {**PLAN, "sample": {"n": 20, "robot.mu": [0.0, 1.0], "robot.I": [5, 6]}}
    ).sample

    for column, low in zip(sample.points.T, (0.0, 5.0), strict=True):
        assert sorted(np.floor((column - low) * 20).astype(int)) == list(range(20))


def test_the_points_of_a_latin_hypercube_lie_anywhere_in_their_strata():
    """Uniform within: mean 1/2, standard deviation 1/sqrt(12), each to five standard errors."""
    sample = plan_of({**PLAN, "sample": {"n": 400, "robot.mu": [0.0, 1.0]}}).sample
    within = sample.points[:, 0] * 400 % 1.0

    assert within.mean() == pytest.approx(0.5, abs=5 / math.sqrt(12 * 400))
    assert within.std() == pytest.approx(1 / math.sqrt(12), abs=5 / math.sqrt(180 * 400) * 1.8)


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"grid": {"robot.mm": [1]}}, ScenarioError, "robot.mm"),
        ({"grid": {"robot.m": []}}, ArgumentError, "at least one value"),
        ({"grid": {"robot.m": [50, -1]}}, ScenarioError, "robot.m"),
        ({"grid": {"robot.mu": [0.1]}}, ArgumentError, "not both"),
        ({"set": {"robot.m": 50}}, ArgumentError, r"robot\.m: .* \[set\] and \[grid\]"),
        ({"set": {"robot": {"mu": 0.1}}}, ArgumentError, r"robot\.mu: .*\[set\] and \[sample\]"),
        ({"figures": ["speed"]}, UnknownNameError, "speed"),
        ({"seeds": 10**12}, ArgumentError, "at most 1e\\+09"),
        ({"seeds": 0}, ScenarioError, "seeds = 0 must be at least 1"),
        ({"sample": {"robot.mu": [0.1, 0.1]}}, ArgumentError, "range"),
        ({"sample": {"seed": -1, "robot.mu": [0, 1]}}, ScenarioError, "sample.seed = -1"),
        ({"sample": {"method": "sobl", "robot.mu": [0, 1]}}, ScenarioError, "near: sobol"),
        ({"stop": {"figure": "violated"}}, ScenarioError, "half_width is missing"),
        ({"stop": {"figur": "violated"}}, UnknownNameError, "near: figure"),
        ({"stop": 3}, ScenarioError, r"written as \[stop\]"),
        ({"stop": {"figure": "tau_rms", "half_width": 0.1}}, UnknownNameError, "tau_rms"),
        ({"grids": {}}, UnknownNameError, "grid"),
        ({"laws": []}, ScenarioError, "laws"),
        ({"guard": ["yes"]}, ScenarioError, r"guard.*\[false, true\]"),
        (
            {"grid": {"guard.enabled": [False, True]}},
            ArgumentError,
            r"\[grid\].*`guard` at the top",
        ),
        ({"guard": [True], "set": {"guard.enabled": False}}, ArgumentError, r"\[set\].*`guard`"),
    ],
)
def test_a_bad_plan_is_refused_by_its_key(changes, error, words):
    with pytest.raises(error, match=words):
        plan_of({**PLAN, **changes})


def test_a_plan_without_a_key_is_refused(tmp_path):
    (tmp_path / "empty.toml").write_text("# nothing yet\n")

    with pytest.raises(ArgumentError, match=r"empty\.toml is empty"):
        load_plan(tmp_path / "empty.toml")


def test_the_guard_that_is_set_for_all_runs_is_what_they_have():
    plan = plan_of({"scenario": "safe-simulation", "set": {"guard": {"enabled": False}}})

    assert [plan.case(cell).guard for cell in range(plan.cells)] == [False]


def test_a_file_may_nest_or_quote_its_keys(tmp_path):
    quoted, nested = tmp_path / "a.toml", tmp_path / "b.toml"
    quoted.write_text('seeds = 2\n[grid]\n"robot.m" = [40, 50]\n')
    nested.write_text("seeds = 2\n[grid.robot]\nm = [40, 50]\n")

    assert load_plan(quoted).identity == load_plan(nested).identity


# -- the same bytes ------------------------------------------------------------------------


@pytest.mark.parametrize("chunk", [1, 7, 60, 1000])
def test_the_table_does_not_depend_on_the_chunks(tmp_path, chunk):
    assert table_of(tmp_path / "a", chunk=chunk) == table_of(tmp_path / "b")


@pytest.mark.parametrize("longest", [1, 7, 59, 60, 1000])
def test_chunks_hold_every_run_once_and_are_nearly_as_long_as_each_other(tmp_path, longest):
    made = []

    def make(chunk, jobs=None):
        made.append(len(chunk.runs))
        return figures(chunk)

    run_study(plan_of({**PLAN, "chunk": longest}), tmp_path / "a", make, FACTS)

    assert sum(made) == plan_of(PLAN).runs
    assert len(made) == math.ceil(sum(made) / longest)
    assert max(made) - min(made) <= 1


@pytest.mark.parametrize("error", [KeyboardInterrupt(), RuntimeError("lost worker")])
def test_an_interrupted_study_goes_on_without_a_lost_or_doubled_run(tmp_path, error):
    plan, made = plan_of(PLAN), []
    for count in (0, 2, 5):
        with pytest.raises(type(error)):
            run_study(plan, tmp_path / "a", refuse_after(count, error), FACTS)

    def make(chunk, jobs=None):
        made.append(len(chunk.runs))
        return figures(chunk)

    kept = [int(path.stem.split("-")[-1]) for path in (tmp_path / "a" / "chunks").iterdir()]
    run_study(plan, tmp_path / "a", make, FACTS)
    assert len(kept) == 7
    assert sum(made) == plan.runs - sum(kept)
    assert (tmp_path / "a" / "table.csv").read_bytes() == table_of(tmp_path / "b")


def test_a_chunk_that_is_damaged_is_made_again(tmp_path):
    before = table_of(tmp_path / "a")
    chunk = sorted((tmp_path / "a" / "chunks").iterdir())[2]
    chunk.write_bytes(chunk.read_bytes()[:-40])

    assert table_of(tmp_path / "a") == before


def test_a_chunk_with_a_flipped_bit_is_missing_or_whole(tmp_path):
    """Whatever the flip makes of the archive: no error, and no number that was not written."""
    plan = plan_of(PLAN)
    with opened(tmp_path, plan, FACTS) as folder:
        path = folder.chunk_path(0, [0, 1])
        chunk = {
            "index": np.arange(2),
            "outcome": np.array(["completed"] * 2),
            "refusal": np.array(["", ""]),
        } | {name: np.arange(2.0) for name in plan.figures}
        folder.keep(path, chunk)
        whole = path.read_bytes()
        missing = 0
        for place in range(len(whole)):
            flipped = bytearray(whole)
            flipped[place] ^= 1 << place % 8
            path.write_bytes(flipped)
            rows = folder.rows(path)
            missing += rows is None
            assert rows is None or all((rows[name] == chunk[name]).all() for name in chunk)

    assert 0.2 * len(whole) < missing < len(whole)


def test_a_full_disk_loses_nothing(tmp_path, monkeypatch):
    save, left = np.savez, [4]

    def full(file, **rows):
        left[0] -= 1
        if left[0] < 0:
            file.write(b"half a chunk")
            raise OSError(errno.ENOSPC, "No space left on device")
        save(file, **rows)

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(ResultFileError, match="Free some space"):
        table_of(tmp_path / "a")
    assert len(list((tmp_path / "a" / "chunks").iterdir())) == 4
    monkeypatch.undo()

    assert table_of(tmp_path / "a") == table_of(tmp_path / "b")


def test_a_folder_of_another_plan_or_version_is_refused_and_kept(tmp_path):
    before = table_of(tmp_path)
    with pytest.raises(ResultFileError, match="another plan"):
        table_of(tmp_path, seeds=4)
    with pytest.raises(ResultFileError, match="version 1 then, 2 now"):
        run_study(plan_of(PLAN), tmp_path, figures, {**FACTS, "version": "2"})

    assert (tmp_path / "table.csv").read_bytes() == before


KILLED = """
import sys, time
from pathlib import Path
from tests.campaign.test_study import FACTS, PLAN, figures, plan_of, run_study
def slow(chunk, jobs=None):
    time.sleep(0.2)
    return figures(chunk)
run_study(plan_of(PLAN), Path(sys.argv[1]), slow, FACTS)
"""


@pytest.mark.skipif(os.name == "nt", reason="SIGKILL is not on Windows")
def test_a_killed_process_leaves_a_study_that_goes_on(tmp_path):
    root = Path(wmr_ctrl.__file__).parents[1]
    command = [sys.executable, "-c", KILLED, tmp_path / "a"]
    process = subprocess.Popen(command, cwd=root, env={**os.environ, "PYTHONPATH": "."})
    while process.poll() is None and len(list((tmp_path / "a").glob("chunks/0*.npz"))) < 3:
        time.sleep(0.02)
    with pytest.raises(ResultFileError, match="another process"):
        table_of(tmp_path / "a")
    process.send_signal(signal.SIGKILL)
    process.wait()

    assert not (tmp_path / "a" / "table.csv").exists()
    assert table_of(tmp_path / "a") == table_of(tmp_path / "b")


# -- stopping ------------------------------------------------------------------------------

STOP = {"figure": "violated", "half_width": 0.2, "first": 8}


def test_a_rule_stops_each_case_at_a_look_and_says_so(tmp_path):
    plan = plan_of({**PLAN, "seeds": 400, "stop": STOP, "chunk": 50})
    result = run_study(plan, tmp_path / "a", figures, FACTS)
    rows = list(csv.DictReader(result.table.read_text().splitlines()))
    counts = {}
    for row in rows:
        cell = int(row["index"]) // 400
        counts[cell] = counts.get(cell, 0) + 1

    assert set(counts.values()) <= {8, 16, 32, 64, 128, 256, 400}
    assert result.runs == len(rows) < plan.runs
    assert result.stopped == plan.cells
    assert [int(row["index"]) for row in rows] == sorted(int(row["index"]) for row in rows)
    with pytest.raises(KeyboardInterrupt):
        run_study(plan, tmp_path / "b", refuse_after(3, KeyboardInterrupt()), FACTS)
    again = run_study(plan, tmp_path / "b", figures, FACTS)
    assert again.table.read_bytes() == result.table.read_bytes()


# -- the real thing ------------------------------------------------------------------------

REAL = {
    "scenario": "far-start",
    "laws": ["mb"],
    "guard": [False, True],
    "seeds": 2,
    "set": {"clock.duration": 1.0, "disturbance.truncate": 3.0},
    "grid": {"actuator.tau_max": [1.0, 20.0]},
    "figures": ["position_rms", "max_abs_v1", "violated", "d_start"],
}


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


def test_a_column_has_the_corridor_of_each_case(tmp_path):
    pytest.importorskip("flint")
    plan = {
        "scenario": "safe-simulation", "laws": ["prox", "smc"], "seeds": 2,
        "set": {"clock.duration": 1.0, "changes": []}, "grid": {"disturbance.std": [0.5, 1.0]},
        "figures": ["corridor", "violated"],
    }  # fmt: skip
    result = wmr_ctrl.study(plan, tmp_path / "s")
    rows = list(csv.DictReader(result.table.read_text().splitlines()))
    told = (tmp_path / "s" / "columns.csv").read_text().splitlines()
    units = {row["name"]: row["unit"] for row in csv.DictReader(told)}

    assert units["corridor"] == "m"
    for row in rows:
        changes = {**plan["set"], "disturbance.std": float(row["disturbance.std"])}
        tube = find_corridor(load_scenario("safe-simulation", changes), row["law"])
        assert row["corridor"] == ("" if row["law"] == "smc" else repr(tube.position))
    with pytest.raises(UnknownNameError, match="corridor"):
        plan_of({**plan, "plant": "mujoco"})


def test_reasons_that_differ_by_numbers_alone_are_one():
    told = [
        "v_u1[1] = 1.5: 2 > 1",
        "",
        "v_u1[1] = 1.5: 2.5e-3 > 1",
        "wheels of 3 N",
        "wheels of 3 N",
    ]

    assert counted_reasons(told) == {"v_u1[1] = 1.5: ... > 1": 2, "wheels of 3 N": 2}


def test_what_is_wrong_without_the_guard_too_is_no_refusal(tmp_path):
    """The guard's runs and the others end in the same words."""
    wrong = {**REAL, "grid": {"clock.control": [0.0105]}}
    told = []
    for guard in (True, False):
        with pytest.raises(ScenarioError) as refused:
            wmr_ctrl.study({**wrong, "guard": [guard]}, tmp_path / str(guard))
        told.append(str(refused.value))

    assert told[0] == told[1]
    assert "clock.plant" in told[0]


@pytest.mark.slow
def test_pictures_are_drawn_from_the_folder_alone(tmp_path):
    pytest.importorskip("matplotlib")
    from wmr_ctrl.report.study_figures import plot_study

    table_of(tmp_path)
    names = {path.name for path in plot_study(tmp_path)}

    assert {"spread.svg", "factors.png", "map.png", "limit-kept.svg"} <= names
    assert all((tmp_path / name).stat().st_size > 2000 for name in names)


def test_nothing_is_drawn_of_a_folder_without_a_table(tmp_path):
    from wmr_ctrl.report.study_figures import plot_study

    with pytest.raises(ResultFileError, match="no finished study"):
        plot_study(tmp_path)


# -- Dask ----------------------------------------------------------------------------------
