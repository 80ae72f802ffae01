"""Output of a finished reproduction with made-up runs: files, page, tables, figures."""

import csv
import json
import re
from dataclasses import replace

import pytest

from benchmarks.paper_figures import PANELS, all_drawings
from tests.report.conftest import drawn_for_the_page
from tests.report.test_drawings import EVIDENCE
from tests.simulation.campaign.synthetic import made_up
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.report.paper_claims import Evidence, Verdict, judge_all
from wmr_ctrl.report.report_page import Facts, Reproduction
from wmr_ctrl.report.tables import scenario_table
from wmr_ctrl.report.write import FILES, write_reproduction
from wmr_ctrl.simulation.campaign.engine import run_campaign
from wmr_ctrl.simulation.campaign.paper_runs import paper_plan
from wmr_ctrl.world.phases import robots_in_words
from wmr_ctrl.world.scenario import load_scenario

FIGURES = [
    *(f"fig{number}{p.letter}_{p.key}" for number in (3, 5) for p in PANELS),
    *EVIDENCE,
]
ALIKE = ("fig3d", "fig3f", "fig3g", "fig3h", "fig3j", "fig3l", "fig5")
SHOWN = [name for name in FIGURES if not name.startswith(ALIKE)]
"""Figures that are drawn by default: those of Fig. 5 are drawn as those of Fig. 3 are, and so are
omega as v1, errors as that of x, and one wheel as the other.
"""
FACTS = Facts(
    titles={"nn": "Adaptive <network>"},
    timings={"pid": 0.001, "smc": 0.002, "mb": 0.003, "nn": 0.01},
    versions={"version": "0.0", "numpy": "2.0"},
)


def reproduction(campaign, **more):
    return Reproduction(campaign, judge_all(Evidence(campaign.table, FACTS.timings)), FACTS, **more)


@pytest.fixture(scope="module")
def shares():
    return []


@pytest.fixture(scope="module")
def written(campaign, shares, tmp_path_factory):
    """All written files; of the figures only those in SHOWN."""
    out = tmp_path_factory.mktemp("made") / "new" / "folder"
    with drawn_for_the_page(SHOWN.__contains__):
        return write_reproduction(
            out, reproduction(campaign), all_drawings(campaign), shares.append
        )


@pytest.fixture(scope="module")
def page(written):
    return written.report.read_text("utf-8")


def test_all_files_are_there_and_nothing_else(written, shares):
    there = {path for path in written.folder.rglob("*") if path.is_file()}

    assert there == set(written.files)
    assert {written.folder / name for name in FILES} <= there
    assert {path.stem for path in there if path.suffix == ".svg"} == set(FIGURES)
    assert len(shares) == len(FIGURES)
    assert shares[-1] == 1.0


# -- the page -----------------------------------------------------------------------------


def test_the_page_needs_nothing_but_itself(page):
    sources = re.findall(r'(?:src|href)="([^"]{1,40})', page)

    assert all(source.startswith(("data:image/svg+xml;base64,", "#")) for source in sources)
    assert not re.search(r"@import|url\(|<script|<link", page)
    assert len(page) < 8_000_000
    assert "Adaptive &lt;network&gt;" in page


def test_links_lead_somewhere_and_every_claim_is_told(written, page):
    targets = set(re.findall(r'id="([^"]+)"', page))

    assert set(re.findall(r'href="#([^"]+)"', page)) <= targets
    assert {f"claim-{one.claim.id}" for one in written.judged} <= targets
    assert all(one.verdict.value in page for one in written.judged)


def test_without_a_change_there_are_no_rows_before_and_after(campaign):
    own = campaign.runs["paper-simulation", campaign.table.laws[0]]
    robots = robots_in_words(load_scenario("paper-simulation"))
    changing = replace(own, settings=replace(own.settings, robots=robots))
    known = replace(campaign, runs={**campaign.runs, (changing.scenario, changing.law): changing})
    with_, without = (
        [row[0] for row in scenario_table(known, name).rows]
        for name in ("paper-simulation", "paper-experiment")
    )

    assert sum("40" in row for row in with_) > 8
    assert not any("40 s" in row or "40–" in row for row in without)


@pytest.mark.parametrize("short", [False, True])
def test_the_distance_from_the_reference_is_the_first_row(campaign, written, short):
    table = scenario_table(campaign, "paper-simulation", short=short)
    first, second = (row[0] for row in table.rows[:2])
    header, _ = table_of(written.folder / "table.csv")
    names = ["position_rms_last_quarter [m]", "position_max [m]"]

    assert first.startswith("RMS distance")
    assert second.startswith("largest distance")
    assert header[5:7] == names


def test_changed_verdicts_are_reported(written, page):
    assert not written.ok
    assert written.changed
    assert f"CHANGED: {written.changed[0].claim.id}" in str(written)
    assert "from what is committed" in page


# -- the data -----------------------------------------------------------------------------


def table_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert {len(row) for row in rows} == {len(header)}
    return header, rows


def test_claims_json_has_all_that_the_verdicts_rest_on(written):
    text = (written.folder / "claims.json").read_text("utf-8")
    content = json.loads(text, parse_constant=pytest.fail)

    assert [claim["id"] for claim in content["claims"]] == [one.claim.id for one in written.judged]
    assert content["seeds"] == [0, 1]
    assert len(content["read_into_the_paper"]) > 10
    for claim in content["claims"]:
        assert claim["verdict"] in set(Verdict)
        assert all(test["found"]["seeds"] >= 1 for test in claim["tests"])


def test_tables_have_units_and_a_row_per_case_and_statistic(written):
    header, rows = table_of(written.folder / "table.csv")

    assert header[:4] == ["scenario", "law", "seeds", "statistic"]
    assert all(re.search(r" \[.+\]$", name) for name in header[4:])
    assert len(rows) == (11 * 4 + 5 * 2) * 7
    column = header.index("tau_peak [N.m]")
    there = {row[3]: row[column] for row in rows if row[:2] == ["paper-experiment", "smc"]}
    expected = written.table.case("paper-experiment", "smc").spread("tau_peak")
    assert float(there["median"]) == expected.median
    assert (float(there["min"]), float(there["max"])) == (expected.min, expected.max)


# -- other campaigns ----------------------------------------------------------------------


def test_runs_without_a_law_of_the_paper_are_refused(tmp_path):
    with made_up():
        few = run_campaign(paper_plan(["mb", "nn"], seeds=1)[:2])

    with pytest.raises(ArgumentError, match="pid, smc"):
        write_reproduction(tmp_path / "new", Reproduction(few, ()), ())
    assert not (tmp_path / "new").exists()
