"""The section past the paper, on made-up runs of a tiny plan."""

from __future__ import annotations

import csv
import re
from collections import Counter

import pytest

from tests.campaign.synthetic import in_turn, prepared
from tests.report.test_reproduce import FACTS, Watch, draw_svg_only
from wmr_ctrl.campaign.ours import our_plan
from wmr_ctrl.campaign.ours_cases import run_ours
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.report.ours.rows import Rows
from wmr_ctrl.report.ours.shortfalls import shortfalls
from wmr_ctrl.report.reproduce import reproduce

LAWS = ("smc", "prox")
TINY = tuple(
    c for c in our_plan(LAWS) if c.factor in ("base", "tau_max = 5 N m") and c.base == "10 ms"
)


@pytest.fixture
def built():
    return Counter()


@pytest.fixture
def build(fake_simulate, built):
    def made(scenario, law, guard, overrides):
        built[law, guard, overrides.get("actuator.tau_max")] += 1
        if guard and overrides.get("actuator.tau_max") == 5.0:
            raise ScenarioError("too weak")
        return lambda seed: fake_simulate(scenario, law, seed)

    return made


def test_each_loop_is_compiled_once_and_refusals_are_rows(build, built):
    watch = Watch()
    rows = run_ours(in_turn, build, TINY, 2, watch)

    assert [row.case for row in rows] == list(TINY)
    assert set(built.values()) == {1}
    assert len(built) == 2 * 2 * len(LAWS)
    assert watch.left == [0, 0]
    assert {r.outcome == "refused" for r in rows if r.case.guard and "5" in r.case.factor} == {True}


def test_an_unguarded_case_that_cannot_be_is_an_error():
    def refusing(*_):
        raise ScenarioError("no")

    with pytest.raises(ScenarioError):
        run_ours(in_turn, refusing, TINY)


@pytest.fixture
def done(fake_simulate, build, tmp_path, monkeypatch):
    monkeypatch.setattr("wmr_ctrl.report.reproduce._draw", draw_svg_only)

    def compare(jobs, progress):
        return run_ours(in_turn, build, TINY, jobs, progress)

    out = tmp_path / "new"
    return reproduce(
        in_turn, prepared(fake_simulate), seeds=1, out=out, facts=FACTS, compare=compare
    )


def test_report_has_the_section_its_figures_and_ours_csv(done):
    page = done.report.read_text(encoding="utf-8")
    targets = set(re.findall(r'id="([^"]+)"', page))

    assert "Past the paper: the guard and our law" in page
    assert set(re.findall(r'href="#([^"]+)"', page)) <= targets
    assert "refused" in page[page.index('id="ours"') :]
    assert len([path for path in done.files if path.name.startswith("ours_")]) == 4
    assert done.folder / "ours.csv" in done.files


def test_ours_csv_has_units_and_a_row_per_run(done):
    with (done.folder / "ours.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)

    assert all(re.search(r" \[.+\]$", name) for name in header[6:])
    assert len(rows) == len(TINY)
    assert all(not any(row[6:]) for row in rows if row[5] == "refused")
    assert len({len(row) for row in (header, *rows)}) == 1


def test_shortfalls_without_rows_are_not_told(build):
    rows = run_ours(in_turn, build, [case for case in TINY if case.factor == "base"])

    assert shortfalls(Rows(rows[:1])) == ()
