"""Alterations of the product's text that tests must notice: world, emitter, C runtime, checks.

Functions that the ledger covers are altered in memory (`tests.alterations`).  Here one place of one
file is altered in a copy of the tree, and the tests named beside it run on the copy; after the word
``prove`` the named entries of the ledger are checked instead.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
COPIED = ("wmr_ctrl", "wmr_proofs", "fmu", "tests", "benchmarks", "pyproject.toml")
PROVE = "prove "
PATIENCE = 300
"""Seconds for the tests of one alteration."""


@dataclass(frozen=True)
class TextAlteration:
    """``new`` for the first ``old`` of a file, and the tests that have to fail then."""

    path: str
    old: str
    new: str
    tests: str


def _listed(kind):
    """Alterations of one kind, as the file beside this one lists them."""
    text = Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
    for group in tomllib.loads(text)[kind]:
        for place in group["places"]:
            yield TextAlteration(*place, group.get("tests", ""))


ALTERED_FILES = tuple(_listed("noticed"))
NOT_NOTICED = tuple(_listed("unnoticed"))
"""Alterations that change no value, so that no test could notice them; the file has the reasons."""


@contextmanager
def altered_copy(base, alteration):
    """Context in which the file of a copied tree is altered; ValueError if it lacks the place."""
    file = base / alteration.path
    text = file.read_text(encoding="utf-8")
    if alteration.old not in text:
        raise ValueError(f"{alteration.path} has no {alteration.old!r} any more")
    file.write_text(text.replace(alteration.old, alteration.new, 1), encoding="utf-8")
    try:
        yield
    finally:
        file.write_text(text, encoding="utf-8")


def copy_of_tree(base):
    """Copy of the project's files that tests need, under ``base``."""
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, base / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, base / name)
    return base


def check_tests(base, rows):
    """Raise RuntimeError if a row names a test that does not exist."""
    tests = (row.tests for row in rows if not row.tests.startswith(PROVE))
    named = sorted({test for text in tests for test in text.split()})
    if not named:
        return
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--co", "-n", "0", "-m", "",
         "-o", f"cache_dir={base / 'cache'}", *named],
        cwd=base, env={**os.environ, "PYTHONPATH": str(base)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(done.stdout + done.stderr)


def failing(base, tests):
    """The first of the tests that fails on a copied tree; empty if all pass.

    Tests that do not end or crash fail, too.  RuntimeError if they could not run at all.
    """
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-m", "", "--tb=no",
               "-o", f"cache_dir={base / 'cache'}", *tests.split()]  # fmt: skip
    if tests.startswith(PROVE):
        command = [sys.executable, "-m", "wmr_ctrl", "prove", "--only", tests.removeprefix(PROVE)]
    env = {**os.environ, "PYTHONPATH": str(base), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            command,
            cwd=base,
            env=env,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
        )
    except subprocess.TimeoutExpired:
        return f"{tests} (did not end)"
    if done.returncode < 0:
        return f"{tests} (crashed)"
    if done.returncode not in (0, 1):
        raise RuntimeError(done.stdout + done.stderr)
    words = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("FAILED")]
    if done.returncode and tests.startswith(PROVE):
        return tests
    errors = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("ERROR")]
    return next(iter([*words, *errors]), "") if done.returncode else ""
