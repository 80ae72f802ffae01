"""Registry entries from other packages' entry points, and errors that name their source."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from traceback import walk_tb
from types import FunctionType
from typing import TypeVar

from wmr_ctrl.core.errors import ArgumentError, WmrError, printable, show

T = TypeVar("T")
_REMEDY = "Mend or uninstall the package that has it."


_LIBRARIES = {*sys.stdlib_module_names, "casadi", "numpy", "wmr_ctrl"}
LONGEST = 400
"""Characters of an error that are shown at most."""


@contextmanager
def blamed(
    what: str,
    remedy: str,
    passing: tuple[type[Exception], ...] = (WmrError,),
    function: Callable[..., object] | None = None,
) -> Iterator[None]:
    """Context that turns errors in another author's code into an ArgumentError starting with
    ``what``.

    It names file and line: where that code failed, else where ``function`` begins.  Errors of type
    ``passing`` are clear enough to a user and are passed on unchanged.
    """
    try:
        yield
    except passing:
        raise
    except Exception as error:
        words = error.msg if isinstance(error, SyntaxError) else str(error)
        said = " ".join(printable(words).split())[:LONGEST].rstrip(".")
        text = ": ".join(filter(None, (type(error).__name__, said)))
        place = _failed_at(error) or _begin_of(function)
        raise ArgumentError(f"{what}: {text}{place}. {remedy}") from error


def _failed_at(error: Exception) -> str:
    """Last file and line of an error outside of libraries; empty if there is none."""
    place = ""
    for frame, line in walk_tb(error.__traceback__):
        module = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if module not in _LIBRARIES:
            place = f" ({frame.f_code.co_filename}, line {line})"
    if isinstance(error, SyntaxError) and error.filename:
        return f" ({error.filename}, line {error.lineno})"
    return place


def _begin_of(function: Callable[..., object] | None) -> str:
    if not isinstance(function, FunctionType):
        return ""
    return f" ({function.__code__.co_filename}, line {function.__code__.co_firstlineno})"


def load(point: EntryPoint, group: str) -> object:
    """The value of an entry point; raises an ArgumentError that names it if it has none."""
    with blamed(f"{_named(point, group)} cannot be loaded", _REMEDY, passing=()):
        return point.load()


def loaded(group: str, kind: type[T]) -> tuple[T, ...]:
    """The values of a group's entry points, in the order of their names.

    Raises an ArgumentError that names the entry point if it is not a ``kind`` or cannot be loaded.
    """
    values = list[T]()
    for point in sorted(entry_points(group=group), key=lambda item: item.name):
        value = load(point, group)
        if not isinstance(value, kind):
            raise ArgumentError(
                f"{_named(point, group)} gives {show(value)}: it must point to a {kind.__name__}. "
                f"{_REMEDY}"
            )
        values.append(value)
    return tuple(values)


def _named(point: EntryPoint, group: str) -> str:
    return f"the entry point {point.name!r} = {point.value!r} of the group {group}"
