"""Run every notebook and write it with its outputs into docs/notebooks.

``python analysis/render.py`` does all, with a name (``05-sample-time``) one.  A cell that raises,
a fact that no longer holds for one, ends the command with its message.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import nbformat
from jupyter_client import KernelManager
from nbclient import NotebookClient
from nbconvert import MarkdownExporter

HERE = Path(__file__).resolve().parent
TARGET = HERE.parent / "docs" / "notebooks"
INDEX = """\
# Notebooks: one question each

`python analysis/render.py` runs the notebooks in `analysis/` and writes these pages: their prose
and figures. Each notebook ends in a cell that asserts every number of its prose.
"""
LONGEST_RUN = 300
"""Seconds that one cell may take."""

COLOUR = re.compile(r"\x1b\[[0-9;]*m")
CODE = re.compile(r"^```python\n(?:.*\n)*?```\n*", re.M)
NOTEBOOK = re.compile(r"(\]\((?:\d\d-[\w-]+))\.ipynb(#[\w-]*)?\)")
"""A link to a notebook, beside which the rendered ones have their own."""


def notebooks(names: list[str]) -> list[Path]:
    """Paths of the named notebooks, or of all in order."""
    return [HERE / f"{name}.ipynb" for name in names] or sorted(HERE.glob("*.ipynb"))


@contextmanager
def kernel() -> Iterator[KernelManager]:
    """A kernel for notebooks in turn: each begins without names, but imports are loaded once."""
    environment = {**os.environ, "PYTHONPATH": str(HERE.parent), "PYTHONWARNINGS": "ignore"}
    environment["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"  # figures as outputs
    manager = KernelManager()
    manager.start_kernel(env=environment, cwd=str(HERE))
    try:
        yield manager
    finally:
        manager.shutdown_kernel(now=True)


def executed(path: Path, manager: KernelManager) -> nbformat.NotebookNode:
    """The notebook with outputs; raises CellExecutionError where a cell fails."""
    book = nbformat.read(path, as_version=4)
    book.cells.insert(0, nbformat.v4.new_code_cell("get_ipython().reset(new_session=True)"))
    client = NotebookClient(book, km=manager, timeout=LONGEST_RUN, allow_errors=False)
    try:
        client.execute()
    finally:
        if client.kc is not None:
            client.kc.stop_channels()
    del book.cells[0]
    return book


def write(book: nbformat.NotebookNode, name: str) -> Path:
    """Markdown and its pictures, in TARGET."""
    resources = {"unique_key": name, "output_files_dir": f"{name}_files"}
    text, found = MarkdownExporter().from_notebook_node(book, resources)
    TARGET.mkdir(parents=True, exist_ok=True)
    for file, content in found["outputs"].items():
        (TARGET / file).parent.mkdir(exist_ok=True)
        (TARGET / file).write_bytes(content)
    clean = "\n".join(line.rstrip().replace("\t", "    ") for line in text.splitlines())
    target = TARGET / f"{name}.md"
    text = re.sub(r"\n{3,}", "\n\n", linked(COLOUR.sub("", clean)))
    target.write_text(without_code(text, name) + "\n", encoding="utf-8")
    return target


def without_code(text: str, name: str) -> str:
    """Prose and figures, with one sentence that says where the code is."""
    title, _, body = CODE.sub("", text).partition("\n\n")
    body = body.strip().removesuffix("## Facts").strip()
    return f"{title}\n\nThe code is in `analysis/{name}.ipynb`.\n\n{body}"


def linked(text: str) -> str:
    """Text whose links to notebooks lead to the rendered ones."""
    return NOTEBOOK.sub(r"\1.md\2)", text)


def index() -> Path:
    """The rendered notebooks' contents: questions and answers of the notebooks' own index."""
    rows = re.findall(
        r"^\| (.+?) \| \[(\d\d)\]\(([\w-]+)\.ipynb\) \| (.+?) \|$",
        (HERE / "README.md").read_text(encoding="utf-8"),
        re.M,
    )
    entries = [f"- [{question}]({name}.md) {answer}" for question, _, name, answer in rows]
    target = TARGET / "index.md"
    target.write_text("\n".join([INDEX, *entries, ""]), encoding="utf-8")
    return target


def main(names: list[str]) -> None:
    """Render what is named, or everything."""
    sys.stderr.write(f"{index().relative_to(HERE.parent)}\n")
    with kernel() as manager:
        for path in notebooks(names):
            sys.stderr.write(f"{path.stem} ... ")
            sys.stderr.flush()
            target = write(executed(path, manager), path.stem)
            sys.stderr.write(f"{target.relative_to(HERE.parent)}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
