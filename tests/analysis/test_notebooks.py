"""The notebooks: cleared, indexed, every number asserted, and each of them runs."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "analysis"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
NAMES = [path.stem for path in NOTEBOOKS]
DECIMAL = re.compile(r"(?<![\w.(])[-+\u2212]?\d+\.\d+(?![\w.])")


def cells(path, kind):
    book = json.loads(path.read_text(encoding="utf-8"))
    return ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == kind]


def spoken(text):
    """Prose without references to equations and to sections."""
    return re.sub(r"Eqs?\. \([^)]*\)", "", text)


def test_the_questions_of_the_analysis_are_all_there():
    assert {name[:2] for name in NAMES} >= {f"{k:02d}" for k in range(1, 9)}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_outputs_are_cleared(path):
    book = json.loads(path.read_text(encoding="utf-8"))
    code = [cell for cell in book["cells"] if cell["cell_type"] == "code"]

    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_a_notebook_asks_a_question_and_ends_in_facts(path):
    first, last = cells(path, "markdown")[0], cells(path, "code")[-1]

    assert "?" in first.splitlines()[0]
    assert last.count("assert") + last.count("said(") > 5


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_every_decimal_of_the_prose_is_asserted_or_given(path):
    """It is in the cell of facts, or it is a given number that the code itself uses."""
    prose = spoken("\n".join(cells(path, "markdown")))
    code = "\n".join(cells(path, "code"))
    known = {number.lstrip("+-") for number in re.findall(r"\d+\.\d+", code)}
    missing = {n for n in DECIMAL.findall(prose) if n.lstrip("+-\u2212") not in known}

    assert missing == set()


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_every_figure_has_a_caption(path):
    figures = sum(source.count("plt.show()") for source in cells(path, "code"))
    captions = sum(len(re.findall(r"^\*Figure \d", s, re.M)) for s in cells(path, "markdown"))

    assert figures == captions > 0


def test_the_index_names_each_notebook_once():
    index = (FOLDER / "README.md").read_text(encoding="utf-8")

    assert [f"{name}.ipynb" for name in NAMES] == re.findall(r"\((\d\d-[\w-]+\.ipynb)\)", index)


@pytest.fixture(scope="session")
def executed():
    """Runs the notebooks of one process, one after another."""
    render = pytest.importorskip("analysis.render", reason="needs the extra notebooks")
    with render.kernel() as manager:
        yield partial(render.executed, manager=manager)


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_a_notebook_runs(path, executed):
    book = executed(path)

    assert any(cell.get("outputs") for cell in book.cells)
