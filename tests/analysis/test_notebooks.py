"""The notebooks: cleared, indexed, every number asserted, and each of them runs."""

import ast
import json
import re
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "analysis"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
NAMES = [path.stem for path in NOTEBOOKS]
DECIMAL = re.compile(r"(?<![\w.(])[-+\u2212]?\d+\.\d+(?![\w.])")


def cells(path, kind):
    book = json.loads(path.read_text(encoding="utf-8"))
    return ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == kind]


def test_the_questions_of_the_analysis_are_all_there():
    assert {name[:2] for name in NAMES} >= {f"{k:02d}" for k in range(1, 9)}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_a_notebook_asks_a_question_and_ends_in_facts(path):
    """Also: the first cell has the settings, outputs are cleared, and every figure has a
    caption.
    """
    book = json.loads(path.read_text(encoding="utf-8"))
    prose, code = cells(path, "markdown"), cells(path, "code")
    shown = [(c["outputs"], c["execution_count"]) for c in book["cells"] if "outputs" in c]
    captions = len(re.findall(r"^\*Figure \d", "\n".join(prose), re.M))

    assert shown == [([], None)] * len(code)
    assert re.match(r'SCENARIO = "[\w-]+"', code[0])
    assert "\n".join(code).count("plt.show()") == captions > 0
    assert "?" in prose[0].splitlines()[0]
    assert code[-1].count("assert") + code[-1].count("said(") > 5


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_every_decimal_of_the_prose_is_asserted_or_given(path):
    """It is in the cell of facts, or it is a given number that the code itself uses."""
    prose = re.sub(r"Eqs?\. \([^)]*\)", "", "\n".join(cells(path, "markdown")))
    code = "\n".join(cells(path, "code"))
    known = {number.lstrip("+-") for number in re.findall(r"\d+\.\d+", code)}
    missing = {n for n in DECIMAL.findall(prose) if n.lstrip("+-\u2212") not in known}

    assert missing == set()


def test_the_index_names_each_notebook_once():
    index = (FOLDER / "README.md").read_text(encoding="utf-8")

    assert [f"{name}.ipynb" for name in NAMES] == re.findall(r"\((\d\d-[\w-]+\.ipynb)\)", index)


def test_each_notebook_has_a_small_figure_in_the_index():
    index = (FOLDER / "README.md").read_text(encoding="utf-8")
    shown = re.findall(r'<img src="(figures/\d\d\.png)" width="\d+" alt="[^"]+">', index)

    assert shown == [f"figures/{name[:2]}.png" for name in NAMES]
    assert all(0 < (FOLDER / figure).stat().st_size <= 40_000 for figure in shown)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
def test_a_notebook_imports_what_the_index_names_alone(path):
    """So it works beside an installed package, in any folder."""
    index = (FOLDER / "README.md").read_text(encoding="utf-8")
    known = {"matplotlib", "numpy", "scipy", "casadi", "control", *sys.stdlib_module_names}
    for node in ast.walk(ast.parse("\n".join(cells(path, "code")))):
        named = [item.name for item in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            named += [f"{node.module}.{item.name}" for item in node.names]
        for name in named:
            inside = {f"`{name}`", f"`{name.rpartition('.')[0]}`"}
            assert name.split(".")[0] in known or any(item in index for item in inside), name


WHEELCHAIR = """
title = "A wheelchair whose motors take torques"
extends = "paper-simulation-nominal"
robot = {m = 150.0, I = 14.0, mu = 0.02, r = 0.17, l = 0.28}
limits = {v_u1 = [1.6, 1.4], v_u2 = [1.3, 1.1]}
reference = {kind = "circle", radius = 3.0, rate = 0.2}
clock = {duration = 12.0}
initial = {pose = [-0.4, -0.3, -0.5]}
"""
VELOCITIES = """
title = "A wheelchair that takes velocities"
extends = "turtlebot3-waffle"
robot = {m = 150.0, I = 14.0, mu = 0.02, r = 0.17, l = 0.28}
clock = {duration = 12.0}
"""
OF_TORQUES = [name for name in NAMES if name[:2] not in ("08", "11")]
OF_VELOCITIES = [name for name in NAMES if name[:2] in ("02", "04", "11", "12")]
"""Notebooks whose question makes sense for another robot of that kind."""


@pytest.fixture(scope="session")
def executed(tmp_path_factory):
    """Runner of the notebooks of one process, one after another, in an empty folder; with a
    scenario.
    """
    render = pytest.importorskip("analysis.render", reason="needs the extra notebooks")
    folder = tmp_path_factory.mktemp("alone")

    def run(name, scenario=None):
        copy = folder / f"{name}.ipynb"
        text = (FOLDER / copy.name).read_text(encoding="utf-8")
        if scenario is not None:
            file = folder / "mine.toml"
            file.write_text(scenario, encoding="utf-8")
            text, count = re.subn(r'"SCENARIO = \\"[\w-]+\\"', r'"SCENARIO = \"mine.toml\"', text)
            assert count == 1
            text = text.replace("CELLS = 150", "CELLS = 40")
        copy.write_text(text, encoding="utf-8")
        book = render.executed(copy, manager)
        return "".join(o.get("text", "") for c in book.cells for o in c.get("outputs", ()))

    with render.kernel(folder) as manager:
        yield run


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_runs(name, executed):
    """The notebook runs alone and checks all its facts."""
    assert "not checked" not in executed(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", OF_TORQUES)
def test_a_notebook_runs_with_a_wheelchair(name, executed):
    assert "not checked" in executed(name, WHEELCHAIR)


@pytest.mark.slow
@pytest.mark.parametrize("name", OF_VELOCITIES)
def test_a_notebook_runs_with_a_base_that_takes_velocities(name, executed):
    said = executed(name, VELOCITIES)

    assert "clip: leaves" in said if name.startswith("11") else "not checked" in said
