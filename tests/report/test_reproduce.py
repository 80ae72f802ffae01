"""The main job with made-up runs: what it writes, what it refuses, what it hands back."""

from __future__ import annotations

import csv
import json
import re

import pytest

from tests.campaign.synthetic import in_turn, prepared
from wmr_ctrl.errors import ArgumentError, ResultFileError
from wmr_ctrl.report.reproduce import FILES, reproduce

FACTS = {
    "titles": {"nn": "Adaptive <network>"},
    "timings": {"pid": 0.001, "smc": 0.002, "mb": 0.003, "nn": 0.01},
    "versions": {"version": "0.0", "numpy": "2.0"},
    "readings": [{"key": "robot.l", "value": 0.25, "unit": "m", "why": "half the track"}],
}


class Watch:
    """Progress that remembers how many steps of each phase are left."""

    def __init__(self):
        self.left, self.ended = [], 0

    def start(self, total, text):
        self.left.append(total)

    def advance(self, count=1):
        self.left[-1] -= count

    def done(self):
        self.ended += 1


@pytest.fixture(scope="module")
def watch():
    return Watch()


@pytest.fixture(scope="module")
def done(fake_simulate, watch, tmp_path_factory):
    out = tmp_path_factory.mktemp("made") / "new" / "folder"
    return reproduce(
        in_turn, prepared(fake_simulate), seeds=2, jobs=1, out=out, progress=watch, facts=FACTS
    )


def test_all_files_are_there_and_nothing_else(done):
    found = {path for path in done.folder.rglob("*") if path.is_file()}

    assert found == set(done.files)
    assert {done.folder / name for name in FILES} <= found
    assert sum(path.suffix == ".svg" for path in found) == 32


def test_the_page_needs_nothing_but_itself(done):
    page = done.report.read_text(encoding="utf-8")
    sources = re.findall(r'(?:src|href)="([^"]{1,40})', page)

    assert all(source.startswith(("data:image/svg+xml;base64,", "#")) for source in sources)
    assert not re.search(r"@import|url\(|<script|<link", page)
    assert len(page) < 8_000_000


def test_links_lead_somewhere_and_every_claim_is_told(done):
    page = done.report.read_text(encoding="utf-8")
    targets = set(re.findall(r'id="([^"]+)"', page))

    assert set(re.findall(r'href="#([^"]+)"', page)) <= targets
    assert {f"claim-{one.claim.id}" for one in done.judged} <= targets
    assert all(one.verdict.value in page for one in done.judged)


def test_texts_from_outside_are_escaped(done):
    page = done.report.read_text(encoding="utf-8")

    assert "Adaptive &lt;network&gt;" in page
    assert "half the track" in page


def test_claims_json_has_all_that_the_verdicts_rest_on(done):
    text = (done.folder / "claims.json").read_text(encoding="utf-8")
    content = json.loads(text, parse_constant=pytest.fail)

    assert [claim["id"] for claim in content["claims"]] == [one.claim.id for one in done.judged]
    assert content["seeds"] == [0, 1]
    assert len(content["read_into_the_paper"]) > 10
    for claim in content["claims"]:
        assert claim["verdict"] in ("HOLDS", "HOLDS IN PART", "DOES NOT HOLD")
        assert all(test["found"]["seeds"] >= 1 for test in claim["tests"])


def test_tables_have_units_and_a_row_per_case_and_statistic(done):
    with (done.folder / "table.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)

    assert header[:4] == ["scenario", "law", "seeds", "statistic"]
    assert all(re.search(r" \[.+\]$", name) for name in header[4:])
    assert len(rows) == 11 * 4 * 7
    assert all(len(row) == len(header) for row in rows)


def test_every_run_is_in_runs_csv(done):
    with (done.folder / "runs.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))

    assert len(rows) == len(done.table)
    assert float(rows[0]["max_abs_v1 [m/s]"]) > 0


def test_changed_verdicts_are_told(done):
    assert not done.ok
    assert done.changed
    assert f"CHANGED: {done.changed[0].claim.id}" in str(done)
    assert "from what is committed" in done.report.read_text(encoding="utf-8")


def test_progress_goes_through_three_phases_to_their_ends(done, watch):
    assert watch.left == [0, 0, 0]
    assert watch.ended == 3


def never(*_args):
    raise AssertionError("nothing must run")


@pytest.mark.parametrize(
    "wrong", [{"seeds": 0}, {"laws": ["mb", "nn"]}, {"laws": ["pid", "smc", "mb", "nn", "nn"]}]
)
def test_impossible_orders_are_refused_before_anything_runs(tmp_path, wrong):
    with pytest.raises(ArgumentError):
        reproduce(never, never, out=tmp_path / "new", **wrong)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("place", ["file", "file/below", "folder"])
def test_places_that_cannot_be_written_are_refused_before_anything_runs(tmp_path, place):
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder" / "report.html").mkdir(parents=True)

    with pytest.raises(ResultFileError):
        reproduce(never, never, out=tmp_path / place)
    assert (tmp_path / "file").read_text() == "mine"


def test_a_campaign_that_fails_leaves_nothing(tmp_path):
    def fail(scenario, law, seed):
        raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        reproduce(in_turn, prepared(fail), seeds=1, out=tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_quick_takes_three_seeds_and_other_laws_stand_beside_the_papers(
    fake_simulate, tmp_path, monkeypatch
):
    monkeypatch.setattr("wmr_ctrl.report.reproduce._draw", draw_svg_only)
    laws = ["pid", "smc", "mb", "nn", "ours"]
    done = reproduce(in_turn, prepared(fake_simulate), laws, quick=True, out=tmp_path)

    assert done.table.laws == tuple(laws)
    assert {row.seed for row in done.table} == {0, 1, 2}
    assert "<th>ours</th>" in done.report.read_text(encoding="utf-8")


def draw_svg_only(drawings, folder, progress):
    """Only what the page shows, to save time."""
    shown = [drawing for drawing in drawings if not drawing.name.endswith("_sheet")]
    return [path for drawing in shown for path in drawing.save(folder, (".svg",))]
