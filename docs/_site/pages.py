"""Parts of pages that are written from the program: never typed, so never out of date.

A block ```` ```{made-from} NAME ```` in a page stands for the Markdown of the function of that
name in `tables`.
"""

from __future__ import annotations

import re

import tables
from sphinx.application import Sphinx

BLOCK = re.compile(r"^```\{made-from\} ([\w-]+)\n```$", re.M)


def filled(text: str) -> str:
    """A page's text with every such block replaced; KeyError for a name that is not there."""
    return BLOCK.sub(lambda match: tables.TABLES[match[1]](), text)


def _read(app: Sphinx, name: str, source: list[str]) -> None:
    source[0] = filled(source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
