"""Parts of pages that are generated from the program, so that they are never out of date.

A block ```` ```{made-from} NAME ```` in a page stands for the Markdown of the function of that name
in `tables`.
"""

from __future__ import annotations

import re
import textwrap

import click
import tables
from sphinx.application import Sphinx

UNSEARCHED = ("ledger", "lemmas")
"""Pages that the search omits: with the text of all proofs they would fill its results."""
BLOCK = re.compile(r"^```\{made-from\} ([\w-]+)\n```$", re.M)


def filled(text: str) -> str:
    """Text of a page with every such block replaced; KeyError for an unknown name."""
    return BLOCK.sub(lambda match: tables.TABLES[match[1]](), text)


def _read(app: Sphinx, name: str, source: list[str]) -> None:
    if BLOCK.search(source[0]):
        source[0] = filled(source[0])
        app.env.note_reread()  # the program may have changed though the page did not


def _unsearched(app: Sphinx, doctree: object) -> None:
    """Limit a page's search entry to its title."""
    if app.env.docname in UNSEARCHED:
        app.env.metadata[app.env.docname]["nosearch"] = "True"


def _epilog(app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """Examples as they stand in the help, columns included."""
    text = (context.command.epilog or "").replace("\b", "").strip()
    lines[:] = ["::", "", *textwrap.indent(text, "   ").splitlines(), ""] if text else []


def _docstring(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Escape |v1| in docstrings: it is an absolute value, not a reST substitution."""
    for place, line in enumerate(lines):
        parts = line.split("``")
        parts[::2] = [part.replace("|", r"\|") for part in parts[::2]]
        lines[place] = "``".join(parts)


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("source-read", _read)
    app.connect("doctree-read", _unsearched)
    app.connect("sphinx-click-process-epilog", _epilog)
    app.connect("autodoc-process-docstring", _docstring)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
