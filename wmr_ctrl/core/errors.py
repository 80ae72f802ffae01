"""Named exceptions. Each message is one paragraph: what is wrong, where, and the remedy."""

import difflib
from collections.abc import Iterable


class WmrError(Exception):
    """Base of every error that a user can cause; the command line prints it and exits with 2."""


class ScenarioError(WmrError, ValueError):
    """A scenario's text, key, type or value is not usable; the message starts with the key path."""


class UnknownNameError(WmrError, KeyError):
    """A name (scenario, law, engine, gain, key) that is not known; the near ones are listed."""

    def __init__(self, kind: str, name: object, known: Iterable[str], remedy: str = "") -> None:
        tail = f" {remedy}" if remedy else ""
        listed = choices(str(name), known)
        super().__init__(f"no {kind} is named {repr(name)[:200]} ({listed}).{tail}")

    def __str__(self) -> str:
        """The message; a KeyError by itself would show it in quotes."""
        return Exception.__str__(self)

    def __reduce__(self) -> tuple[object, ...]:
        """Between processes it travels as its message."""
        return BaseException.__new__, (type(self), *self.args)


def install(extra: str) -> str:
    """The command that installs an extra, spelled as in the documentation, for any shell."""
    return f"pip install 'wmr_ctrl[{extra}]'"


class CompilerError(WmrError, RuntimeError):
    """No C compiler was found, or it refused the generated source."""


class CacheError(CompilerError):
    """Compiled code cannot be stored: a full disk, say, whatever the compiler."""


class DeviceError(WmrError, RuntimeError):
    """A graphics processor is not there, has too little memory, or failed."""


class ResultFileError(WmrError, ValueError):
    """A saved run cannot be read, or a result cannot be written."""


class MissingExtraError(WmrError, ImportError):
    """An optional package is missing; the message names what to install."""


class ArgumentError(WmrError, ValueError):
    """An argument of the command line or of the Python interface is out of its range."""


def choices(name: str, known: Iterable[str]) -> str:
    """Say which of the ``known`` names are near ``name``, then list all."""
    options = sorted(known)
    near = difflib.get_close_matches(name, options, n=3, cutoff=0.4)
    hint = f"near: {', '.join(near)}; " if near else ""
    return f"{hint}known: {', '.join(options) or 'none'}"
