"""Text in the tree speaks of the project only."""

import re

import pytest

from tests.architecture.tree import ROOT, text_files

MACHINE_PATH = re.compile(r"(?<![\w.$}/-])/(?:home|root|work|tmp|Users|mnt|scratch)/[\w.]")
LONGEST_TEXT = 3_000_000


def test_no_file_names_a_folder_of_somebodys_machine():
    found = [
        f"{path.relative_to(ROOT)}: {match.group()}"
        for path in text_files()
        for match in MACHINE_PATH.finditer(path.read_text(encoding="utf-8"))
    ]

    assert found == []


@pytest.mark.parametrize("folder", ["wmr_ctrl", "tests", "docs", "fmu", ".ci", "analysis"])
def test_text_has_no_tabs_at_line_starts_or_trailing_blanks(folder):
    written = (".py", ".c", ".h", ".md", ".toml", ".xml")
    found = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in text_files()
        if path.relative_to(ROOT).parts[0] == folder and path.suffix in written
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if line != line.rstrip() or line.startswith("\t")
    ]

    assert found == []


def test_no_build_product_or_oversized_text_is_tracked():
    assert [path.name for path in text_files() if path.stat().st_size > LONGEST_TEXT] == []


def test_cases_that_are_not_slow_are_there(request):
    """A case that no longer has this name, or that is slow by another mark, would be lost."""
    named, run = set(), set()
    for item in request.session.items:
        function = item.nodeid.partition("[")[0]
        marks = item.iter_markers("slow_but")
        named |= {f"{function}[{case}]" for mark in marks for case in mark.args}
        run.add(item.nodeid)

    assert named <= run


@pytest.mark.parametrize("script", sorted(path.name for path in (ROOT / ".ci").iterdir()))
def test_folders_that_a_script_hands_to_pytest_are_there(script):
    text = (ROOT / ".ci" / script).read_text(encoding="utf-8")
    named = re.findall(r"(?<![\w.$}/-])(?:tests|docs|wmr_ctrl|fmu)/[\w./]*", text)

    assert [name for name in named if not (ROOT / name).exists()] == []
