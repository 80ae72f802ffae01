"""Every command and every block of code on the pages: it parses, and with its page it runs."""

import contextlib
import doctest
import io
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.docs.pages import ROOT, written_pages
from wmr_ctrl.cli import console
from wmr_ctrl.cli.root import root
from wmr_ctrl.report import animate

PAGES = written_pages()
OWN_TEST = {
    "docs/extending.md": "tests/docs/test_extending.py",
    "docs/gallery.md": "tests/docs/test_pictures.py",
    "benchmarks/README.md": "tests/benchmarks",
    "README.md": "tests/docs/test_readme.py",
}
"""Pages whose blocks another test runs."""
RUNNABLE = [
    page
    for page in PAGES
    if page.name not in OWN_TEST and any(block.tried for block in page.blocks)
]
LONGEST = 240
"""Seconds that one command may take."""


def named(pages):
    return pytest.mark.parametrize("page", pages, ids=[page.name for page in pages])


def calls(page):
    """Calls of wmr-ctrl in prose and in blocks, each up to a pipe or the end of the line."""
    in_prose = re.findall(r"`wmr-ctrl\s([^`]+)`", page.prose)
    in_blocks = [
        found
        for block in page.blocks
        for found in re.findall(r"^(?:\$ .*?)?wmr-ctrl ([^|>&#\n]*)", block.text, re.M)
    ]
    return [" ".join(call.split()) for call in in_prose + in_blocks]


@named(PAGES)
def test_commands_and_their_options_exist(page):
    for call in calls(page):
        words = call.split()
        if words[0].isupper() or words[0].startswith("-"):
            continue  # `wmr-ctrl COMMAND --help`
        command = root.commands[words[0]]
        known = {name for item in command.params for name in (*item.opts, *item.secondary_opts)}
        options = {word.strip("[]").partition("=")[0] for word in words if word.startswith("--")}
        assert options <= known | {"--help"}, call


@named(PAGES)
def test_blocks_say_what_they_are_and_parse(page):
    for block in page.blocks:
        place = f"{page.name}:{block.line}"
        assert block.language, f"{place} has no language"
        if block.language == "python":
            compile(block.text, place, "exec")
        if block.language == "toml":
            tomllib.loads(block.text)
        if block.language == "console" and page.name not in OWN_TEST:
            assert block.commands, f"{place} has no line that begins with $"


def test_pages_with_a_test_of_their_own_have_it():
    assert [name for name in OWN_TEST.values() if not (ROOT / name).exists()] == []
    for page in PAGES:
        for block in page.blocks:
            if block.mark.startswith("tried by "):
                assert (ROOT / block.mark.removeprefix("tried by ")).exists(), block


def done_by(command, folder):
    """Run a command of a page: wmr-ctrl alone in this process, anything else in a shell.

    tests/cli has the tests of the process itself.
    """
    program, *words = shlex.split(command)
    if program != "wmr-ctrl" or set("|<>&;$`\\*?").intersection(command):
        return shell(command, folder)
    with pytest.MonkeyPatch.context() as patch:
        if words[0] == "identify":
            patch.setenv("WMR_CTRL_OPTIMIZE", "1")  # a fit takes longer than its compiler
        found = CliRunner().invoke(root, words)
    raised = found.exception if found.exit_code not in (0, 2) else ""
    return subprocess.CompletedProcess(
        words, found.exit_code, found.stdout, f"{found.stderr}{raised}"
    )


def shell(command, folder):
    scripts = Path(sys.executable).parent
    environment = {**os.environ, "PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}"}
    return subprocess.run(
        ["bash", "-c", command], cwd=folder, env=environment, timeout=LONGEST,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT if "2>&1" in command else subprocess.PIPE,
        stdin=subprocess.DEVNULL, text=True, check=False,
    )  # fmt: skip


def agrees(told, printed):
    """True if the page shows the printed text; white space is ignored, and ... matches anything."""
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    return not told.strip() or doctest.OutputChecker().check_output(told, printed, flags)


def run_commands(page, block, folder):
    for command, told in block.commands:
        done = done_by(command, folder)
        text = done.stdout + (done.stderr if block.exit_code or not done.stdout else "")
        place = f"{page.name}:{block.line}: {command}"
        assert done.returncode == block.exit_code, f"{place}\n{done.stdout}{done.stderr}"
        assert agrees(told, text), f"{place}\nprinted\n{text}\nthe page says\n{told}"


def run_python(page, block, names, printed):
    with contextlib.redirect_stdout(printed):
        exec(compile(block.text, f"{page.name}:{block.line}", "exec"), names)


@pytest.mark.slow
@named(RUNNABLE)
def test_a_page_does_what_it_says(page, tmp_path, monkeypatch):
    """All blocks of a page in order, in a separate folder with the tables beside the page."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(console, "FIRST", math.inf)  # how long a command takes is no page's matter
    monkeypatch.setitem(animate._FRAMES, ".gif", 12)  # tests/report has all of them
    for table in page.path.parent.glob("*.csv"):
        shutil.copy(table, tmp_path)
    names = {"__name__": "__main__"}
    for block in page.blocks:
        if block.file:
            (tmp_path / block.file).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / block.file).write_text(block.text, "utf-8")
        elif block.tried and block.language == "console":
            run_commands(page, block, tmp_path)
        elif block.tried:
            run_python(page, block, names, io.StringIO())
