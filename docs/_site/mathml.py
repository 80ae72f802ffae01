"""Formulas as MathML, which browsers draw by themselves: no script and no network."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx

DIGITS = re.compile(r"\\frac(\d)(\d)")
"""A half without braces, which docutils reads as a fraction of twelve."""
SPELT = {r"\dots": r"\ldots"}
"""Commands that docutils knows under another name."""


def mathml(text: str, *, block: bool = False) -> str:
    """A formula of LaTeX as MathML; MathError for a command that docutils does not know."""
    for name, known in SPELT.items():
        text = text.replace(name, known)
    text = DIGITS.sub(r"\\frac{\1}{\2}", text)
    bare = text.lstrip().startswith(("^", "_"))  # s$^2$: an index of nothing
    return tex2mathml("{}" + text if bare else text, as_block=block)


def _inline(translator: Any, node: nodes.Element) -> None:
    translator.body.append(mathml(node.astext()))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.Element) -> None:
    text = mathml(node.astext(), block=True)
    translator.body.append(f'<div class="math">{text}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
