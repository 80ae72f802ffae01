"""XML text as a tree, without entities and without a network; xacro expanded."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import TYPE_CHECKING

from wmr_ctrl.core.errors import ScenarioError, printable, show

from .found import LARGEST

if TYPE_CHECKING:
    from lxml.etree import _Element as Element

XACRO = "xacro"
"""Prefix of the tags that xacro expands, whatever its address."""
EXPAND = "Expand it where it is installed, by `xacro FILE NAME:=VALUE > robot.urdf`, and give that."


def tree(text: str, place: str) -> Element:
    """Root element of an XML text.  Raises ScenarioError if it is damaged or declares entities."""
    from lxml import etree

    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True
    )
    try:
        root = etree.fromstring(text.encode(), parser)
    except (etree.XMLSyntaxError, ValueError) as problem:
        raise ScenarioError(f"{place} is not valid XML: {printable(str(problem))[:200]}.") from None
    if root.getroottree().docinfo.doctype:
        raise ScenarioError(
            f"{place} has a DOCTYPE, which may declare entities: they are not expanded here. "
            "Remove it, and write what they stand for."
        )
    for item in root.iter("{*}*"):
        if item.prefix != XACRO:
            item.tag = etree.QName(item).localname
    return root


def has_macros(root: Element) -> bool:
    """True if xacro has something to expand."""
    return any(XACRO in item.nsmap for item in root.iter())


def expanded(file: Path, place: str) -> str:
    """The text of a xacro file with all macros expanded, arguments at their defaults.

    Known packages are the one that contains the file, and those beside it. Raises ScenarioError if
    xacro fails.
    """
    import xacro
    from xacro import substitution_args

    before, said = substitution_args._eval_find, io.StringIO()
    substitution_args._eval_find = lambda name: str(package(name, file))
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            result: str = xacro.process_file(str(file), verbosity=0).toxml()
    except Exception as problem:  # whatever an expression of the user's file raises
        inner = problem.__context__ if isinstance(problem.__context__, ScenarioError) else problem
        reason = printable(str(inner) or type(inner).__name__)[:300]
        raise ScenarioError(f"{place} cannot be expanded by xacro: {reason}. {EXPAND}") from None
    finally:
        substitution_args._eval_find = before
    return result


def package(name: str, file: Path) -> Path:
    """Folder of the ROS package ``name``: it contains ``file``, or is beside such a package."""
    for folder in file.resolve().parents:
        if (folder / "package.xml").is_file():
            for other in sorted(folder.parent.glob("*/package.xml")):
                if f"<name>{name}</name>" in other.read_text(encoding="utf-8", errors="replace"):
                    return other.parent
    raise ScenarioError(
        f"$(find {name[:80]}): this package is neither around the file nor beside its package"
    )


def numbers(item: Element, path: str, name: str, place: str, count: int) -> tuple[float, ...]:
    """Numbers of an attribute of the element at ``path``; zeros if it is absent."""
    part = item.find(path)
    value = None if part is None else part.get(name)
    if value is None:
        return (0.0,) * count
    with contextlib.suppress(ValueError):
        result = tuple(map(float, value.split()))
        if len(result) == count and all(abs(x) <= LARGEST for x in result):
            return result
    many = "a number" if count == 1 else f"{count} numbers"
    raise ScenarioError(f"{place}: {path} {name} = {show(value)} must be {many} of usual size.")
