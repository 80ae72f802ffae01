"""Run every notebook, write its figures into docs/notebooks, and a small one for README.md.

``python analysis/render.py`` runs all; with a name (``05-sample-time``) one. A cell that raises,
such as a fact that no longer holds, ends the command with its message.
"""

from __future__ import annotations

import base64
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import nbformat
from jupyter_client import KernelManager
from nbclient import NotebookClient
from PIL import Image

HERE = Path(__file__).resolve().parent
TARGET = HERE.parent / "docs" / "notebooks"
FIGURES = HERE / "figures"
"""One small figure of each notebook, which README.md shows."""
SHOWN = {"02": 1, "05": 1, "10": 1, "11": 2}
"""Index of the figure that stands for a notebook, if not the first."""
COLOURS, WIDEST = 48, 720
"""Number of colours, and width in pixels, of a small figure."""
INDEX = """\
# Notebooks: one question each

`python analysis/render.py` runs the notebooks in `analysis/` and writes their figures into these
pages; the site adds the prose. Each notebook ends in a cell that asserts every number of it.
"""
LONGEST_RUN = 300
"""Seconds that one cell may take."""


def notebooks(names: list[str]) -> list[Path]:
    """Paths of the named notebooks, or of all in order."""
    return [HERE / f"{name}.ipynb" for name in names] or sorted(HERE.glob("*.ipynb"))


@contextmanager
def kernel(folder: Path) -> Iterator[KernelManager]:
    """Kernel for one notebook after another: each starts with no names; modules are loaded once.

    Its working directory is ``folder``, which has no file of the repository.
    """
    environment = {**os.environ, "PYTHONPATH": str(HERE.parent), "PYTHONWARNINGS": "ignore"}
    environment["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"  # figures as outputs
    manager = KernelManager()
    manager.start_kernel(env=environment, cwd=str(folder))
    try:
        yield manager
    finally:
        manager.shutdown_kernel(now=True)


def executed(path: Path, manager: KernelManager) -> nbformat.NotebookNode:
    """Run a notebook and return it with outputs; raises CellExecutionError if a cell fails."""
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
    """Write pictures, and a page that shows them, to TARGET; the site adds the notebook's text."""
    folder = TARGET / f"{name}_files"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for place, cell in enumerate(book.cells):
        pictures = [output.data["image/png"] for output in cell.get("outputs", ())
                    if "image/png" in output.get("data", ())]  # fmt: skip
        for number, picture in enumerate(pictures):
            file = folder / f"{name}_{place}_{number}.png"
            file.write_bytes(base64.b64decode(picture))
    target = TARGET / f"{name}.md"
    target.write_text(figures(book.cells[0].source, name, folder), encoding="utf-8")
    return target


def figures(opening: str, name: str, folder: Path) -> str:
    """Markdown page with the notebook's title and its pictures."""
    title = opening.partition("\n")[0]
    files = _in_order(folder)
    shown = "\n\n".join(f"![Figure]({folder.name}/{file.name})" for file in files)
    said = f"The figures of `analysis/{name}.ipynb`, which has their captions."
    return f"{title}\n\n{said}\n\n{shown}\n"


def small_figure(folder: Path, name: str) -> Path:
    """Write the figure of a notebook for README.md, in few colours, on white."""
    files = _in_order(folder)
    picture = Image.open(files[SHOWN.get(name[:2], 0)])
    picture.thumbnail((WIDEST, WIDEST))
    white = Image.new("RGB", picture.size, "white")
    white.paste(picture, mask=picture.convert("RGBA").getchannel("A"))
    FIGURES.mkdir(exist_ok=True)
    target = FIGURES / f"{name[:2]}.png"
    white.quantize(COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)
    return target


def _in_order(folder: Path) -> list[Path]:
    return sorted(folder.iterdir(), key=lambda file: int(file.stem.split("_")[-2]))


def index() -> Path:
    """Index page of the notebooks, with the questions of ``analysis/README.md``."""
    rows = re.findall(
        r"^\| (.+?) \| \[\d\d\]\(([\w-]+)\.ipynb\)",
        (HERE / "README.md").read_text(encoding="utf-8"),
        re.M,
    )
    entries = [f"- [{question}]({name}.md)" for question, name in rows]
    target = TARGET / "index.md"
    target.write_text("\n".join([INDEX, *entries, ""]), encoding="utf-8")
    return target


def main(names: list[str]) -> None:
    """Render the named notebooks, or all."""
    sys.stderr.write(f"{index().relative_to(HERE.parent)}\n")
    with tempfile.TemporaryDirectory() as folder, kernel(Path(folder)) as manager:
        for path in notebooks(names):
            sys.stderr.write(f"{path.stem} ... ")
            sys.stderr.flush()
            book = executed(path, manager)
            target = write(book, path.stem)
            small_figure(target.with_name(f"{path.stem}_files"), path.stem)
            sys.stderr.write(f"{target.relative_to(HERE.parent)}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
