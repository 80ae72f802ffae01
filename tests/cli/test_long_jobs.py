"""`wmr-ctrl reproduce` and `bench`: the options that they pass on, and their answers."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from wmr_ctrl import api


class Verdicts(SimpleNamespace):
    """Result of a made-up job."""

    def __init__(self, out, agrees):
        super().__init__(report=Path(out) / "report.html", as_expected=agrees)

    def __str__(self):
        return "8 claims" if self.as_expected else "8 claims\nCHANGED: claim 2"


@pytest.fixture
def asked(monkeypatch):
    """Replace the job by one that agrees, and remember its arguments."""
    calls = []

    def job(out, **options):
        options["progress"](0.5)
        calls.append({"out": str(out), **options})
        return Verdicts(out, len(calls) == 1)

    monkeypatch.setattr(api, "reproduce", job, raising=False)
    return calls


@pytest.mark.parametrize(
    "options, seeds, ours",
    [
        ("", 20, False), ("--quick", "quick", False), ("--seeds 7 --with-ours", 7, True),
        ("--quick --seeds 1", 1, False),
    ],
)  # fmt: skip
def test_number_of_seeds_and_whether_the_comparison_past_the_paper_is_asked_for(
    wmr, asked, tmp_path, options, seeds, ours
):
    assert wmr(f"reproduce --out {tmp_path}/r {options}").exit_code == 0
    assert seeds == ("quick" if asked[0]["quick"] else asked[0]["seeds"])
    assert (asked[0]["jobs"], asked[0]["with_ours"]) == (None, ours)


def test_agreement_is_exit_code_0_and_a_difference_1(wmr, asked, tmp_path):
    same, other = (wmr(f"reproduce --out {tmp_path} --jobs 2") for _ in range(2))

    assert same.exit_code == 0
    assert "report.html" in same.stderr
    assert other.exit_code == 1
    assert same.stdout == "8 claims\n"
    assert other.stdout == "8 claims\nCHANGED: claim 2\n"
    assert asked[0]["jobs"] == 2


def test_bench_prints_its_table_and_writes_all_measurements_as_strict_json(
    wmr, tmp_path, monkeypatch
):
    found = {"ratios": {"loop": 2.0}, "times": {"nn": float("nan")}, "text": "loop  2"}
    monkeypatch.setattr(api, "bench", lambda progress: found)
    done = wmr(f"bench --json {tmp_path}/b.json")
    document = json.loads((tmp_path / "b.json").read_text(), parse_constant=pytest.fail)

    assert (done.exit_code, done.stdout) == (0, "loop  2\n")
    assert document["times"] == {"nn": None}
