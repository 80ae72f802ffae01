"""The paper's equations as data: complete, and each with a home that names it."""

import ast
import re
from importlib import import_module
from pathlib import Path

import pytest

import wmr_ctrl
import wmr_proofs
from wmr_ctrl.core.paper import CITATION
from wmr_proofs.paper import equations, symbols

TAG = re.compile(r"Eqs?\.\s*((?:\(\d+\)[\s,\-]*(?:and\s+)?)+)")
ITEM = re.compile(r"\((\d+)\)(?:-\((\d+)\))?")
PACKAGE = Path(wmr_ctrl.__file__).parent
PROOFS = Path(wmr_proofs.__file__).parent
COUNT = 88


def numbers(text):
    """Equation numbers that a docstring names, ranges filled."""
    found = set()
    for group in TAG.findall(text):
        for first, last in ITEM.findall(group):
            found |= set(range(int(first), int(last or first) + 1))
    return found


def docstrings():
    for path in (*PACKAGE.rglob("*.py"), *PROOFS.rglob("*.py")):
        if not TAG.search(text := path.read_text(encoding="utf-8")):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef):
                yield ast.get_docstring(node) or ""


def test_numbers_are_exactly_those_of_the_paper():
    assert [item.number for item in equations()] == list(range(1, COUNT + 1))


@pytest.mark.parametrize("item", equations(), ids=lambda item: str(item.number))
def test_home_exists_and_carries_the_number(item):
    """The home's own docstring has the number; for a claim, its row or its file's docstring may."""
    path, _, name = item.home.partition(":")
    module = import_module(path)
    home = getattr(module, name) if name else module
    texts = [home.__doc__, module.__doc__ if ".claims." in path else ""]

    assert item.number in numbers(" ".join(text or "" for text in texts))


def test_every_equation_is_named_by_some_docstring():
    named = set().union(*(numbers(text) for text in docstrings()))

    assert named == set(range(1, COUNT + 1))


def test_fields_are_of_the_known_kinds():
    assert {item.role for item in equations()} <= {"definition", "identity", "inequality"}
    assert {item.status for item in equations()} <= {"as printed", "corrected", "stated only"}
    assert all(item.title for item in equations())
    assert all(item.note for item in equations() if item.status != "as printed")


def test_symbols_and_citation():
    names = [item.symbol for item in symbols()]

    assert len(names) == len(set(names)) > 40
    assert "10.1109/TIE.2020.2989711" in CITATION
