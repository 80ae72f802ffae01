"""Tests and what they test: a file's test is found by its name."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

from tests.architecture.tree import ROOT, nodes_of

TESTS = ROOT / "tests"


@cache
def parsed() -> dict[Path, ast.Module]:
    """Every Python file below tests, parsed."""
    return {path: ast.parse(path.read_text("utf-8")) for path in sorted(TESTS.rglob("*.py"))}


def test_what_tests_import_of_each_other_is_there():
    missing = {
        f"{path.relative_to(ROOT)}: {node.module}"
        for path, tree in parsed().items()
        for node in nodes_of(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tests.")
        if not is_there(node.module or "")
    }

    assert missing == set()


def is_there(module: str) -> bool:
    path = ROOT.joinpath(*module.split("."))
    return path.is_dir() or path.with_suffix(".py").is_file()
