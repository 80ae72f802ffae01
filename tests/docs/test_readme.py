"""The README is short, and its commands are those of the program."""

import json
import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from wmr_ctrl.cli.root import root

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text("utf-8")
DEMO = re.findall(r"^wmr-ctrl (run far-start-drop .*)$", TEXT, flags=re.M)


def test_it_is_short_and_names_the_topic_early():
    assert len(TEXT.split()) <= 800
    assert "cmd_vel" in "\n".join(TEXT.splitlines()[:30])


@pytest.mark.parametrize("call", DEMO)
def test_the_guard_of_the_demo_keeps_the_limit_that_the_law_alone_breaks(call):
    """No assumption of the guarantee is void in the demo, and the robot starts far away."""
    found = json.loads(CliRunner().invoke(root, [*shlex.split(call), "--json"]).stdout)

    assert len(DEMO) == 2
    guarded = bool(found["guard"])
    assert guarded == ("--guard" in call)
    assert guarded == (found["violations"] == 0)
    if guarded:
        assert found["outcome"] == "completed"
        assert "assumption-void" not in [item["key"] for item in found["remarks"]]
        assert found["position_rms"]["all"] > 1.0 > 0.1 > found["position_rms"]["last_quarter"]


def test_fmu_readme_lists_every_folder_and_nothing_else():
    folder = ROOT / "fmu"
    tables = (folder / "README.md").read_text("utf-8")
    listed = re.findall(r"^\| `([\w/]+)/` \|", tables, flags=re.M)
    found = {path.name for path in folder.iterdir() if path.is_dir()}

    assert sorted(listed) == sorted({*found, "fmi/headers"})
