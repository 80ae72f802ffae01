"""Named exceptions; each message is one paragraph with fault, place and remedy.

The message of a ScenarioError begins with the path of a key.  Values are spelled by `show`.
"""

import difflib
import reprlib
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from numbers import Rational, Real
from types import ModuleType

DEEPEST = 3
"""Arrays within arrays whose elements a message shows."""
_REPR = reprlib.Repr()
_REPR.maxother = 80


class WmrError(Exception):
    """Base of every error that a user can cause; the command line prints it and exits with 2."""


class ScenarioError(WmrError, ValueError):
    """A scenario's text, key, type or value is not usable; the message starts with the key path."""


class UnknownNameError(WmrError, KeyError):
    """A name (scenario, law, engine, gain, key) that does not exist; similar names are listed."""

    def __init__(self, kind: str, name: object, known: Iterable[str], remedy: str = "") -> None:
        tail = f" {remedy}" if remedy else ""
        listed = choices(str(name), known)
        super().__init__(f"no {kind} is named {repr(name)[:200]} ({listed}).{tail}")

    def __str__(self) -> str:
        """The message; plain KeyError would show it in quotes."""
        return Exception.__str__(self)

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle as the message alone, to pass between processes."""
        return BaseException.__new__, (type(self), *self.args)


class UnknownKeyError(ScenarioError, UnknownNameError):
    """A key that a scenario does not have; the message lists the similar keys and all others."""

    def __init__(self, path: str, known: Iterable[str]) -> None:
        head, _, name = path.rpartition(".")
        place = f"in {head}" if head else "at the top of a scenario"
        Exception.__init__(self, f"{path} is not a key {place}; {choices(name, known)}.")


def install(extra: str) -> str:
    """The command that installs an extra, spelled as in the documentation, for any shell."""
    return f"pip install 'wmr_ctrl[{extra}]'"


class CompilerError(WmrError, RuntimeError):
    """No C compiler was found, or it refused the generated source."""


class CacheError(CompilerError):
    """Compiled code cannot be stored, for example because the disk is full."""


class DeviceError(WmrError, RuntimeError):
    """A graphics processor is missing, has too little memory, or failed."""


class ResultFileError(WmrError, ValueError):
    """A saved run cannot be read, or a result cannot be written."""


class MissingExtraError(WmrError, ImportError):
    """An optional package is missing; the message names what to install."""


class ArgumentError(WmrError, ValueError):
    """An argument of the command line or of the Python interface is out of its range."""


def library(name: str, extra: str = "data") -> ModuleType:
    """A module of an optional package; raises MissingExtraError if it is not installed."""
    try:
        return import_module(name)
    except ImportError as error:
        missing = isinstance(error, ModuleNotFoundError)
        fault = "is not installed" if missing else f"cannot be imported ({error})"
        raise MissingExtraError(
            f"this needs {name.partition('.')[0]}, which {fault}: {install(extra)}."
        ) from None


def choices(name: str, known: Iterable[str]) -> str:
    """Text on the ``known`` names: first those similar to ``name``, then all."""
    options = sorted(known)
    near = difflib.get_close_matches(name, options, n=3, cutoff=0.4)
    hint = f"near: {', '.join(near)}; " if near else ""
    return f"{hint}known: {', '.join(options) or 'none'}"


def show(value: object) -> str:
    """Return ``value`` as a TOML file would spell it, cut to a readable length.

    It takes no longer for a value that is large, or deeply nested through repeated parts.
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
