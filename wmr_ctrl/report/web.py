"""What pages are made with: templates, and drawings that follow the reader's colours."""

from __future__ import annotations

import base64
import re
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from wmr_ctrl.report.style import AFTER_DARK, INK


def page_environment() -> Environment:
    """The templates; texts are escaped, and a name that is not given is an error."""
    return Environment(
        loader=PackageLoader("wmr_ctrl.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


_COLOUR = re.compile(r"(?<=: )#[0-9a-f]{6}\b")
"""A colour in a style, as matplotlib writes it."""


def picture(path: Path) -> str:
    """An SVG file as the address of an image, so that the page needs no other file."""
    text = two_schemes(path.read_text(encoding="utf-8"))
    return "data:image/svg+xml;base64," + base64.b64encode(text.encode()).decode("ascii")


def two_schemes(svg: str) -> str:
    """The drawing with its colours as names, and both meanings of each name: light and dark.

    A colour that has no dark one stays as it is in both.
    """
    head, tag, body = svg.partition("<svg")
    attributes, end, rest = body.partition(">")
    return head + tag + attributes + end + _STYLE + _COLOUR.sub(_name, rest)


def _name(match: re.Match[str]) -> str:
    return f"var(--{match[0][1:]})" if match[0] in AFTER_DARK else match[0]


def _values(dark: bool) -> str:
    return "".join(
        f"--{colour[1:]}:{after if dark else colour};" for colour, after in AFTER_DARK.items()
    )


# Text without a style of its own inherits the drawing's.
_STYLE = (
    f"<style>svg{{fill:var(--{INK[1:]});{_values(False)}}}"
    f"@media (prefers-color-scheme:dark){{svg{{{_values(True)}}}}}</style>"
)
