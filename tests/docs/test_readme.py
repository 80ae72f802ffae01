"""The README's commands and example are those of the program."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from wmr_ctrl.cli.root import root

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


def test_python_example_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WMR_CTRL_OPTIMIZE", "1")  # a thousand runs outweigh what that takes
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.S)
    exec(compile(code, "README.md", "exec"), {})
