"""Pages of runs and studies are self-contained, and their numbers are JSON's."""

import html
import json
import re

import pytest
from click.testing import CliRunner

from wmr_ctrl import simulate
from wmr_ctrl.cli import root
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.report.run_page import write_run_page
from wmr_ctrl.report.run_rows import rows_of
from wmr_ctrl.report.study_shares import shares_of
from wmr_ctrl.report.study_table import read_study
from wmr_ctrl.results import json_safe, summary
from wmr_ctrl.world.scenario import load_scenario

SHORT = {"clock.duration": 1.0, "metrics.split": 0.5, "metrics.rms_from": 0.2}
DATA = re.compile(r'<script type="application/json" id="summary">(.*?)</script>', re.S)


@pytest.fixture(scope="module", params=["far-start", "turtlebot3-burger"])
def run(request):
    return simulate(load_scenario(request.param, SHORT), "kanayama", engine="numpy")


def alone(text):
    """Assert that nothing is loaded from elsewhere, with both colour schemes and print."""
    loaded = re.findall(r'(?:src|href|url)\s*[=(]\s*["\']?([^"\')\s>]+)', text)

    assert all(address.startswith(("data:image/svg+xml;base64,", "#")) for address in loaded)
    assert "prefers-color-scheme: dark" in text
    assert "@media print" in text
    assert "<link" not in text


def test_the_page_of_a_run_is_whole_and_has_its_figures(run, tmp_path):
    write_run_page(run, tmp_path / "run.html")
    text = (tmp_path / "run.html").read_text("utf-8")
    seen = html.unescape(re.sub(r"<[^>]+>", " ", text.partition("</style>")[2]))

    alone(text)
    assert json.loads(DATA.search(text)[1]) == json.loads(json.dumps(json_safe(summary(run))))
    for name, value in rows_of(run, verbose=True):
        assert name in seen
        assert value in seen
    assert all(remark.text in seen for remark in run.remarks)
    assert run.explanation in seen
    assert run.provenance["scenario_toml"].strip() in seen
    assert run.provenance["scenario_hash"] in seen
    assert text.count("data:image/svg+xml;base64,") == 1


def test_a_page_has_one_format(run, tmp_path):
    with pytest.raises(WmrError, match="html"):
        write_run_page(run, tmp_path / "run.pdf")
    assert list(tmp_path.iterdir()) == []


def test_a_study_ends_with_the_shares_of_its_table(tmp_path):
    """The shares count the finished runs, by law, guard and point of the grid."""
    (tmp_path / "plan.toml").write_text(
        'scenario = "far-start"\nlaws = ["mb", "pid"]\nguard = [false, true]\nseeds = 2\n'
        "set = {clock.duration = 3.0, disturbance.truncate = 3.0, limits.v_u2 = [5e-4, 5e-4]}\n"
        "grid = {limits.v_u1 = [[1.0, 1.5], [1e-3, 1e-3]]}\n"
    )
    page = tmp_path / "study.html"
    words = ("study", tmp_path / "plan.toml", "--out", tmp_path / "s", "--json", "--report", page)
    done = CliRunner().invoke(root, [*map(str, words)])
    assert done.exit_code == 0, done.stderr
    shares = json.loads(done.stdout)["shares"]
    table, text = read_study(tmp_path / "s"), page.read_text("utf-8")
    broken = table.numbers["violated"]

    alone(text)
    assert json.loads(DATA.search(text)[1])["shares"] == shares
    assert len(shares) == 8
    assert sum(share["runs"] + share["refused"] for share in shares) == len(table.group)
    kept = sum(share["kept"] * share["runs"] for share in shares if share["runs"])
    assert kept == pytest.approx((broken == 0).sum())
    assert 0 < kept < len(table.group) - sum(share["refused"] for share in shares)
    assert any(share["refused"] and share["kept"] is None for share in shares)
    assert [share.cells[0] for share in shares_of(table)] == [share["cell"] for share in shares]
