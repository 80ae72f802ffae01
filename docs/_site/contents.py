"""Table of contents of the site, from the lists of links on its index pages.

On a page called ``index.md`` every link at the start of a list item is an entry, and the heading
above it the entry's caption. Forges show the same page as plain Markdown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from sphinx.application import Sphinx

ENTRY = re.compile(r"^[-*] \[[^\]]+\]\(([^)#:]+)\.md\)", re.M)
PART = re.compile(r"^## (.+)$", re.M)


def parts(text: str) -> Iterator[tuple[str, list[str]]]:
    """Heading ("" before the first) and linked pages of each part of an index page."""
    found = ["", *PART.split(text)]
    for heading, body in zip(found[::2], found[1::2], strict=True):
        pages = list(dict.fromkeys(ENTRY.findall(body)))
        if pages:
            yield heading, pages


def toctree(heading: str, pages: list[str]) -> str:
    """A hidden table of contents."""
    caption = [f":caption: {heading}"] if heading else []
    return "\n".join(["```{toctree}", ":hidden:", *caption, "", *pages, "```"])


def _read(app: Sphinx, name: str, source: list[str]) -> None:
    if name.rpartition("/")[2] == "index":
        source[0] = "\n\n".join([source[0], *(toctree(*part) for part in parts(source[0]))])


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
