"""`wmr-ctrl study`: its output and files, and one paragraph for each impossible request."""

import csv
import json
import re

import pytest

from tests.commands import flat
from tests.tables import cases

PLAN = """\
laws = ["mb"]
seeds = 3
[set]
clock.duration = 1.0
[grid]
limits.v_u2 = [[0.8, 1.3], [0.7, 1.2]]
"""


@pytest.fixture
def plan(tmp_path):
    (tmp_path / "plan.toml").write_text(PLAN)
    return tmp_path / "plan.toml"


def test_a_plan_leaves_a_table_and_says_where(wmr, plan, tmp_path):
    first = wmr(f"study {plan} --out {tmp_path}/s --json")
    again = wmr(f"study {plan} --out {tmp_path}/s --jobs 1")

    assert first.exit_code == 0, first.stderr
    assert json.loads(first.stdout)["runs"] == 6
    assert "6 of 6 planned runs" in again.stdout
    with (tmp_path / "s" / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["limits.v_u2"] for row in rows] == ["[0.8, 1.3]"] * 3 + ["[0.7, 1.2]"] * 3


@pytest.mark.parametrize("begun", [True, False])
def test_who_interrupts_is_told_that_it_goes_on(wmr, plan, tmp_path, monkeypatch, begun):
    def stop(*_given, **_more):
        if begun:
            (tmp_path / "s").mkdir()
        raise KeyboardInterrupt

    monkeypatch.setattr("wmr_ctrl.api.study", stop)
    done = wmr(f"study {plan} --out {tmp_path}/s")

    assert done.exit_code == 130
    assert ("the same command goes on from there" in flat(done.stderr)) is begun


@pytest.mark.parametrize(
    "text, words",
    cases("""
    laws = ["nno"] | no law is named 'nno'
    seeds = | not valid TOML
    grid.robot.mm = [1.0] | robot.mm
    # nothing | is empty
    seeds = 1 | no executor is named 'spark'
    """),
)
def test_bad_input_is_one_paragraph(wmr, tmp_path, text, words):
    (tmp_path / "plan.toml").write_text(text)
    more = "--executor spark" if "spark" in words else ""
    result = wmr(f"study {tmp_path}/plan.toml --out {tmp_path}/s {more}")

    assert result.exit_code == 2
    assert words in flat(result.stderr)
    assert not (tmp_path / "s").exists()
    assert wmr(f"study {tmp_path}/plan.toml").exit_code == 2


ALL_REFUSED = """\
guard = true
laws = ["mb"]
seeds = 2
[set]
clock.duration = 1.0
guard.dbar = [9000.0, 15.0]
[sample]
n = 3
robot.mu = [0.0, 1.0]
"""


def test_a_study_of_which_the_guard_refuses_all_is_no_success(wmr, tmp_path):
    (tmp_path / "plan.toml").write_text(ALL_REFUSED)
    found = wmr(f"study {tmp_path}/plan.toml --out {tmp_path}/s --json")
    told = wmr(f"study {tmp_path}/plan.toml --out {tmp_path}/s")
    ((reason, count),) = json.loads(found.stdout)["refused"].items()

    assert (found.exit_code, told.exit_code) == (1, 1)
    assert (count, reason.startswith("guard: no force can keep limits.v_u1[1]")) == (6, True)
    assert f"6 refused: {reason}" in flat(told.stdout)


SOBOL = """\
laws = ["pid"]
seeds = 1
[set]
clock.duration = 0.1
[sample]
method = "sobol"
n = 4
robot.mu = [0.1, 0.2]
robot.m = [50.0, 60.0]
"""


def test_sobols_points_are_as_many_as_their_indices_need(wmr, tmp_path):
    pytest.importorskip("SALib")
    (tmp_path / "plan.toml").write_text(SOBOL)
    found = wmr(f"study {tmp_path}/plan.toml --out {tmp_path}/s --json")

    assert found.exit_code == 0, found.stderr
    assert json.loads(found.stdout)["runs"] == 4 * (2 + 2)


@pytest.mark.parametrize(
    "text, words",
    cases("""
    nothing | study.json cannot be read
    {"plan": {"grid": {}, "sample": null}} | columns.csv cannot be read
    { | damaged
    """),
)
def test_what_cannot_be_drawn_is_one_paragraph(wmr, tmp_path, text, words):
    if text != "nothing":
        (tmp_path / "study.json").write_text(text)
    found = wmr(f"study plot {tmp_path}")

    assert found.exit_code == 2
    assert words in flat(found.stderr)
    assert not re.search("Errno|Error:", found.stderr)
