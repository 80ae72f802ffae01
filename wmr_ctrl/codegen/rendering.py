"""Generated text: one engine for its templates, and names that end nothing in it."""

from __future__ import annotations

from pathlib import Path

import jinja2

from wmr_ctrl.fields.problems import printable


def text_engine(folder: Path) -> jinja2.Environment:
    """The templates of a folder, for text that is no markup: C, Modelica, MATLAB, Markdown.

    Its filter ``comment`` is for whatever a user has named.
    """
    engine = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder), trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, undefined=jinja2.StrictUndefined,
    )  # fmt: skip
    engine.filters["comment"] = comment
    return engine


def comment(text: str) -> str:
    """A text that ends no line, no comment of C and no code of Markdown, and begins none."""
    return printable(text).replace("*/", "* /").replace("/*", "/ *").replace("`", "'")
