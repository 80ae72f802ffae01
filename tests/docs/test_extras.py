"""Hints at extras have one spelling, which every shell takes, and pages begin with theirs."""

import re
import tomllib
from pathlib import Path

import pytest

from wmr_ctrl.core.errors import install

ROOT = Path(__file__).parents[2]
CODE = [*(ROOT / "wmr_ctrl").rglob("*.py"), *(ROOT / "wmr_proofs").rglob("*.py")]
OTHERS = ("notebooks", "ledger.md", "lemmas.md", "changes.md", "architecture.md", "contributing.md")
PAGES = [ROOT / "README.md"] + [
    path
    for path in (ROOT / "docs").rglob("*.md")
    if not {*OTHERS} & {*path.relative_to(ROOT).parts}
]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
HINT = re.compile(r"pip install (?:--[\w-]+ )*(.*)")
SPELLED = re.compile(r"'wmr_ctrl\[[\w,]+\]'|-e '\.\[dev\]'")
SAID = re.compile(r"extras?\s+`(\w+)`|" + re.escape(install("NAMES")).replace("NAMES", r"([\w,]+)"))


def test_code_has_one_function_for_hints():
    home = ROOT / "wmr_ctrl" / "core" / "errors.py"
    found = {path for path in CODE if "pip install" in path.read_text("utf-8")}

    cosim = ROOT / "wmr_ctrl" / "export" / "cosim"
    assert found == {home, cosim / "__init__.py"}  # FMPy is no extra
    assert install("tune") == "pip install 'wmr_ctrl[tune]'"


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_a_page_begins_with_its_extras(page):
    text = page.read_text("utf-8")
    hints = [said.partition("`")[0] for said in HINT.findall(text)]
    wrong = [said for said in hints if "[" in said and not SPELLED.match(said)]
    named = {name for pair in SAID.findall(text) for name in ",".join(pair).split(",")} - {""}
    lines = text.splitlines()
    title = next(k for k, line in enumerate(lines) if line.startswith("# "))

    assert wrong == []
    assert named <= {*PROJECT["optional-dependencies"]}
    assert not named or lines[title + 2] == f"Extras: `{install(','.join(sorted(named)))}`."
