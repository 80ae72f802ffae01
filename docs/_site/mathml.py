"""Formulas as MathML, which browsers draw by themselves: no script and no network."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx

DIGITS = re.compile(r"\\frac(\d)(\d)")
"""``\\frac12`` without braces, which docutils misreads."""
MATHML = "http://www.w3.org/1998/Math/MathML"
ElementTree.register_namespace("", MATHML)
DOTS = "˙¨"
"""Accents for which docutils puts an index below the letter."""
SPELT = {r"\dots": r"\ldots"}
"""Commands that docutils knows by another name."""


def mathml(text: str, *, block: bool = False) -> str:
    """A formula of LaTeX as MathML; MathError for a command that docutils does not know."""
    for name, known in SPELT.items():
        text = text.replace(name, known)
    text = DIGITS.sub(r"\\frac{\1}{\2}", text)
    bare = text.lstrip().startswith(("^", "_"))  # s$^2$: an index of nothing
    return _indexed(tex2mathml("{}" + text if bare else text, as_block=block))


def _indexed(text: str) -> str:
    """MathML with the index of a dotted letter beside the letter, not below."""
    if not any(dot in text for dot in DOTS):
        return text
    tree = ElementTree.fromstring(text)
    for both in tree.iter(f"{{{MATHML}}}munderover"):
        letter, index, accent = both
        if accent.text in DOTS:
            dotted = ElementTree.Element(f"{{{MATHML}}}mover", {"accent": "true"})
            dotted.extend((letter, accent))
            both.tag, both[:] = f"{{{MATHML}}}msub", [dotted, index]
    return ElementTree.tostring(tree, encoding="unicode")


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
