"""Laws from users: a file with ``LAW``, or a Law; registered by name when first given."""

import ast
import os
import sys
from collections.abc import Iterable
from contextlib import redirect_stdout
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import TypeAlias

from wmr_ctrl.core.errors import ArgumentError, show
from wmr_ctrl.core.fields.files import read_text
from wmr_ctrl.core.fields.plugins import blamed

from .law import Law
from .registry import LAWS

LawGiven: TypeAlias = str | Path | Law
"""A law's name, the path of its file, or the law itself."""
SUFFIX = ".py"
LAW = "LAW"
_MEND = "Mend the file."


def is_law_file(given: str | os.PathLike[str]) -> bool:
    """True if a text is the path of a law's file, not a law's name."""
    text = os.fspath(given)
    return not isinstance(given, str) or text.endswith(SUFFIX) or os.path.basename(text) != text


def law_name(given: LawGiven, folder: str | os.PathLike[str] = ".") -> str:
    """Name under which the registry keeps a law; paths are relative to ``folder``.

    Raises ArgumentError or ScenarioError for a file that cannot be read or whose LAW is invalid.  A
    name is returned unchanged: looking it up raises the error for an unknown one.
    """
    if isinstance(given, Law):
        return LAWS.add(given)
    if not is_law_file(given):
        return str(given)
    path = Path(folder, given)
    text = read_text(path, "law", (SUFFIX,))
    name = LAWS.add(_law_in(str(path), text), _place(str(path), text))
    LAWS.files[name] = str(path)
    return name


def law_if_any(given: LawGiven | None) -> str | None:
    """`law_name`, or None for None."""
    return None if given is None else law_name(given)


def law_names(given: Iterable[LawGiven], folder: str | os.PathLike[str] = ".") -> tuple[str, ...]:
    """Names of several laws, by `law_name`; ArgumentError if two different ones share a name."""
    named: dict[str, Law | None] = {}
    names = []
    for item in given:
        name = law_name(item, folder)
        law = LAWS.given.get(name)
        if named.setdefault(name, law) is not law:
            raise ArgumentError(
                f"two different laws are called {name!r}. Give one of them another name: the first "
                "argument of its Law(...)."
            )
        names.append(name)
    return tuple(names)


@lru_cache(maxsize=256)
def _law_in(path: str, text: str) -> Law:
    """The law of a file with that text; the file is executed once for each text."""
    module = ModuleType(f"wmr_law_of_{Path(path).stem}")
    module.__file__ = path
    sys.modules[module.__name__] = module  # where dataclasses look annotations up
    with blamed(f"the law in {path} cannot be loaded", _MEND, passing=()):
        code = compile(text, path, "exec")
        try:
            with redirect_stdout(sys.stderr):  # stdout may be one JSON document
                exec(code, vars(module))
        except SystemExit as error:
            raise RuntimeError("the file ends the program") from error
    values = vars(module)
    if isinstance(law := values.get(LAW), Law):
        return law
    if LAW in values:
        raise ArgumentError(
            f"{_place(path, text)}: LAW is {show(law)}, and must be a Law: LAW = Law(...), as "
            "docs/extending.md shows."
        )
    others = [name for name, value in values.items() if isinstance(value, Law)]
    hint = (
        f"Its law is called {others[0]}: name it LAW."
        if others
        else ("Write LAW = Law(...) at its end, as docs/extending.md shows.")
    )
    raise ArgumentError(f"{path} defines no LAW. {hint}")


def _place(path: str, text: str) -> str:
    """The file and the line that defines LAW."""
    lines = [
        node.lineno
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Name) and node.id == LAW and isinstance(node.ctx, ast.Store)
    ]
    return f"{path}, line {lines[-1]}" if lines else path
