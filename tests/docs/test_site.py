"""The documentation site builds without warnings and without a network; its tables are complete."""

import dataclasses
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.docs.pages import DOCS, ROOT
from wmr_ctrl.cli.root import root
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core import signals
from wmr_ctrl.core.signals import Signal
from wmr_ctrl.world.scenario.scenario import sections


@pytest.fixture
def tables(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_site"))
    import tables

    return tables


def test_every_key_of_a_scenario_is_on_the_page(tables):
    text = tables.scenario_keys()

    for key, section in sections().items():
        part = text.partition(f"### `[{key}]`\n")[2].partition("### ")[0]
        for field in dataclasses.fields(section):
            assert f"| `{field.name}` |" in part, f"{key}.{field.name}"


def test_every_signal_of_the_catalogue_is_in_the_glossary(tables):
    values = [v for name, v in vars(signals).items() if name.isupper() and name != "LOG_HEAD"]
    flat = [s for v in values for s in (v if isinstance(v, tuple) else (v,))]
    told = {s.name for group in tables.catalogue().values() for s in group}

    assert {s.name for s in flat if isinstance(s, Signal)} == told


def test_every_law_has_its_gains_and_every_command_its_line(tables):
    assert all(f"[gains.{law}]" in tables.gains() for law in LAWS)
    assert all(f"`wmr-ctrl {name}`" in tables.command_table() for name in root.commands)


def test_every_part_is_asked_for_by_a_page_and_can_be_written(tables):
    text = "".join(path.read_text("utf-8") for path in DOCS.rglob("*.md"))

    assert set(re.findall(r"\{made-from\} ([\w-]+)", text)) == set(tables.TABLES)
    assert all(write().strip() for write in tables.TABLES.values())


def test_documentation_can_be_read():
    """Pages have a word budget; a page that does not fit proposes an omission."""
    made = ("ledger.md", "lemmas.md", "api.md")
    pages = [path for path in DOCS.rglob("*.md") if path.name not in made]

    assert sum(len(path.read_text("utf-8").split()) for path in pages) <= 45_000


def test_a_page_of_a_notebook_has_all_its_prose_and_figures(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_site"))
    page = pytest.importorskip("notebooks", reason="needs the extra docs").page
    for notebook in sorted((ROOT / "analysis").glob("*.ipynb")):
        shown = page(notebook, DOCS / "notebooks").replace(".md", ".ipynb")
        cells = json.loads(notebook.read_text("utf-8"))["cells"]
        prose = [line for c in cells if c["cell_type"] == "markdown" for line in c["source"]]
        figures = (DOCS / "notebooks" / f"{notebook.stem}_files").iterdir()

        assert [line for line in prose if line.strip() not in shown] in ([], ["## Facts"])
        assert {figure.name for figure in figures} == set(re.findall(r"[\w-]+\.png", shown))


def test_indices_of_dotted_letters_stand_beside_them(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_site"))
    mathml = pytest.importorskip("mathml", reason="needs the extra docs").mathml
    text = re.sub(r"\s+", "", mathml(r"\dot e_3 + \sum_i^n \dot\omega"))

    assert '<msub><moveraccent="true"><mi>e</mi>' in text
    assert "<munderover>" not in re.sub(r"<munderover>(<[^>]*>)*∑", "", text)


def test_the_live_page_is_written_where_there_is_none(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_site"))
    live = pytest.importorskip("live", reason="needs the extra docs")
    app = SimpleNamespace(builder=SimpleNamespace(format="html"), outdir=str(tmp_path))
    page = root.commands["page"]
    monkeypatch.setattr(page, "callback", lambda **_given: 1 / 0)
    with pytest.raises(Exception, match=r"wmr-ctrl page failed.*division by zero"):
        live._finished(app, None)
    monkeypatch.setattr(page, "callback", lambda out, **_given: Path(out).write_text("drawn"))
    for _ in range(2):
        live._finished(app, None)
        assert (tmp_path / live.NAME).read_text() == "drawn"


@pytest.mark.slow
def test_the_site_builds_without_warnings_and_loads_nothing_from_elsewhere(tmp_path):
    """The live page is left out because it is slow; tests/export/page checks it."""
    pytest.importorskip("sphinx", reason="needs the extra docs")
    out = tmp_path / "site"
    out.mkdir()
    (out / "robot.html").write_text("<!doctype html>", "utf-8")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    proxies = dict.fromkeys(("http_proxy", "https_proxy"), "http://127.0.0.1:9")
    done = subprocess.run(
        [*command, "-d", str(tmp_path / "doctrees"), str(DOCS), str(out)],
        cwd=ROOT, env={**os.environ, **proxies}, capture_output=True, text=True, check=False,
        timeout=600,
    )  # fmt: skip

    assert done.returncode == 0, done.stdout + done.stderr
    pages = list(out.rglob("*.html"))
    assert len(pages) > 40
    loaded = r"<(?:script|img|iframe)[^>]+src=\"(https?:[^\"]+)|<link[^>]+href=\"(https?:[^\"]+)"
    assert {m for page in pages for m in re.findall(loaded, page.read_text("utf-8"))} == set()
    assert leading_nowhere(out) == []
    assert searched(out).isdisjoint({"ledger", "lemmas"})


def searched(out):
    """Pages whose text, not only their title, is in the search index."""
    text = (out / "searchindex.js").read_text("utf-8")
    index = json.loads(text[text.index("{") : text.rindex("}") + 1])
    numbers = [n if isinstance(n, list) else [n] for n in index["terms"].values()]
    found = {index["docnames"][k] for each in numbers for k in each}
    assert {"guarantee", "filter"} <= found
    return found


def leading_nowhere(out):
    """Links of the built pages to missing files."""
    found = []
    for page in out.rglob("*.html"):
        for target in re.findall(r"<a [^>]*?href=\"([^\"#]+)", page.read_text("utf-8")):
            if not re.match(r"\w+:", target) and not (page.parent / target).exists():
                found.append(f"{page.relative_to(out)}: {target}")
    return found
