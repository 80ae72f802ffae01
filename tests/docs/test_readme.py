"""The README's commands and example are those of the program."""

from __future__ import annotations

import json
import re
from pathlib import Path

from click.testing import CliRunner

from wmr_ctrl.cli.root import root
from wmr_ctrl.control.laws.registry import NAMES

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def test_commands_and_their_options_exist() -> None:
    for call in re.findall(r"`wmr-ctrl ([^`]+)`", TEXT):
        words = call.split()
        command = root.commands[words[0]]
        known = {name for item in command.params for name in (*item.opts, *item.secondary_opts)}
        assert {word for word in words if word.startswith("--")} <= known | {"--help"}, call
        assert CliRunner().invoke(root, [words[0], "--help"]).exit_code == 0


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert (ROOT / target).exists(), target


def rows_below(heading: str, text: str) -> dict[str, list[str]]:
    """Cells by law, of the first table below a heading."""
    lines = text[text.index(heading) :].split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("| law |")) + 2
    cells = [line.strip("| ").split(" | ") for line in lines[first : lines.index("", first)]]
    return {row[0]: row[1:] for row in cells}


def test_distances_are_those_of_the_page() -> None:
    """The median RMS on the preset's own circle, at each period."""
    page = (ROOT / "docs" / "tracking.md").read_text(encoding="utf-8")
    shown = rows_below("## How well it tracks", TEXT)
    periods = re.findall(r"^### (\d+ ms), ", page, flags=re.M)
    told = [rows_below(f"### {period}", page) for period in periods]

    assert f"| law | {' | '.join(periods)} |" in TEXT
    assert shown.keys() == set(NAMES)
    for law, cells in shown.items():
        assert cells == [page_rows[law][0].split(",")[0] for page_rows in told]


def test_the_command_that_guarantees_the_limit_keeps_it() -> None:
    """No assumption of the guarantee is void there, and the robot comes from far away."""
    (call,) = re.findall(r"\| guarantee the limit \| `wmr-ctrl (.*?)`", TEXT)
    found = json.loads(CliRunner().invoke(root, [*call.split(), "--json"]).stdout)

    assert found["guard"]
    assert (found["outcome"], found["violations"]) == ("completed", 0)
    assert "assumption-void" not in [item["key"] for item in found["remarks"]]
    assert found["position_rms"]["all"] > 1.0 > 0.1 > found["position_rms"]["last_quarter"]


def test_python_example_runs() -> None:
    """As it is printed but for the number of runs."""
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.S)
    fewer = code.replace("range(1000)", "range(20)")

    assert fewer != code
    exec(compile(fewer, "README.md", "exec"), {})


def test_fmu_readme_lists_every_folder_and_nothing_else():
    folder = ROOT / "fmu"
    tables = (folder / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `([\w/]+)/` \|", tables, flags=re.M)
    found = {path.name for path in folder.iterdir() if path.is_dir()}

    assert sorted(listed) == sorted({*found, "fmi/headers"})
