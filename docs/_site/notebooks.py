"""Pages of notebooks: text from the notebooks in ``analysis``, figures from beside the pages.

A page in the tree shows the figures alone; the site adds the notebook's text around them.
"""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path

from sphinx.application import Sphinx

NOTEBOOKS = Path(__file__).parents[2] / "analysis"
LINK = re.compile(r"(\]\(\d\d-[\w-]+)\.ipynb\b")
"""Link to a notebook; its page has the same name."""


def page(notebook: Path, pages: Path) -> str:
    """Markdown of a notebook's prose, with the figures that `analysis/render.py` drew."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    folder = pages / f"{notebook.stem}_files"
    figures = iter(sorted(folder.glob("*.png"), key=order))
    parts = []
    for cell in cells:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
        for figure in itertools.islice(figures, source.count("plt.show()")):
            parts.append(f"![Figure]({folder.name}/{figure.name})")
    title, _, body = "\n\n".join(parts).partition("\n\n")
    body = LINK.sub(r"\1.md", body).strip().removesuffix("## Facts")
    return f"{title}\n\nThe code is in `analysis/{notebook.name}`.\n\n{body}\n"


def order(figure: Path) -> list[int]:
    """Numbers at the end of a figure's name: its cell, and its position within the cell."""
    return [int(number) for number in figure.stem.rsplit("_", 2)[-2:]]


def _read(app: Sphinx, name: str, source: list[str]) -> None:
    notebook = NOTEBOOKS / f"{name.removeprefix('notebooks/')}.ipynb"
    if name.startswith("notebooks/") and notebook.exists():
        app.env.note_dependency(str(notebook))
        source[0] = page(notebook, Path(app.srcdir) / "notebooks")


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
