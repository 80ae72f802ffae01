"""Wording of scenario errors: the key path first, then what is wrong, then the remedy."""

import reprlib
from collections.abc import Iterable, Mapping, Sequence
from numbers import Rational, Real

from wmr_ctrl.core.errors import ScenarioError, UnknownNameError, choices

DEEPEST = 3
"""Arrays within arrays whose elements a message shows."""
_REPR = reprlib.Repr()
_REPR.maxother = 80


class UnknownKeyError(ScenarioError, UnknownNameError):
    """A key that a scenario does not have; the message lists the near ones and all others."""

    def __init__(self, path: str, known: Iterable[str]) -> None:
        head, _, name = path.rpartition(".")
        place = f"in {head}" if head else "at the top of a scenario"
        Exception.__init__(self, f"{path} is not a key {place}; {choices(name, known)}.")


def show(value: object) -> str:
    """Return ``value`` as a TOML file would spell it, cut to a readable length.

    It takes no longer for a value that is large, or deep by naming its parts many times over.
    """
    text = _spell(value, DEEPEST)
    return text if len(text) <= 60 else text[:57] + "..."


def printable(text: str) -> str:
    """The text with a space for every control character."""
    return "".join(c if c.isprintable() else " " for c in text)


def _spell(value: object, depth: int) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{printable(value[:80])}"'
    if isinstance(value, int):
        return str(value) if abs(value) < 10**30 else "an integer beyond 1e30"
    if isinstance(value, Real):
        return _REPR.repr(value) if isinstance(value, Rational) else repr(float(value))
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, Sequence) and not isinstance(value, bytes):
        items = [_spell(item, depth - 1) for item in value[:8]] if depth else ["..."]
        return "[" + ", ".join(items) + "]"
    return " ".join(_REPR.repr(value).split())
