"""Checks of the Python interface's arguments against the annotations of the function."""

import builtins
import inspect
import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import lru_cache, wraps
from itertools import islice, repeat
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError, show

LOOKED_AT = 1000
"""Elements of a collection whose type is looked at; there may be millions of seeds."""
_EITHER = inspect.Parameter.POSITIONAL_OR_KEYWORD

P = ParamSpec("P")
T = TypeVar("T")


class _Absent:
    """Placeholder for a class that is imported for typing alone; a subclass has its name."""


class _Names(dict[str, Any]):
    """Namespace of a module; names that exist for typing alone become `_Absent` classes."""

    def __missing__(self, name: str) -> Any:
        if name.startswith("__"):
            raise KeyError(name)  # a debugger asks for such
        return vars(builtins).get(name) or type(name, (_Absent,), {})


def checks_arguments(function: Callable[P, T]) -> Callable[P, T]:
    """Wrap the function so that it checks its arguments against its annotations.

    A class that is imported for typing alone is recognised by its name; options that are a
    TypedDict are checked one by one; a path must be one that the system accepts.  Raises
    ArgumentError for a value of another type and for a missing argument, UnknownNameError for an
    unknown argument.
    """
    signature, name = inspect.signature(function), function.__qualname__
    named = signature.parameters.items()
    places = [key for key, item in named if item.kind == _EITHER]
    needed = {key for key, item in named if item.default is inspect.Parameter.empty}
    plain = {item.kind for _, item in named} <= {_EITHER, inspect.Parameter.KEYWORD_ONLY}

    @wraps(function)
    def checking(*args: P.args, **kwargs: P.kwargs) -> T:
        hints = hints_of(function)
        for key in kwargs:
            if key not in hints:
                raise UnknownNameError(f"argument of {name}", key, hints)
        try:
            given = dict(zip(places, args, strict=False))
            whole = len(given) == len(args) and needed <= given.keys() | kwargs.keys()
            if not plain or not whole or given.keys() & kwargs.keys():  # to bind takes long
                given = signature.bind(*args, **kwargs).arguments
        except TypeError as problem:
            raise ArgumentError(f"{name}: {problem}. Its arguments: {', '.join(hints)}.") from None
        for key, value in (given | kwargs).items():
            if key in hints and type(value) is not hints[key]:  # mostly it is
                check(value, hints[key], f"{name}: {key}")
        return function(*args, **kwargs)

    return checking


def check_fields(value: object) -> None:
    """Raise ArgumentError unless each field of a dataclass's object is of its annotated type."""
    for key, hint in hints_of(type(value).__init__).items():
        check(vars(value)[key], hint, f"{type(value).__name__}: {key}")


@lru_cache(maxsize=256)
def hints_of(function: Callable[..., object]) -> Mapping[str, object]:
    """Types of a function's arguments by name, with the entries of a TypedDict of options."""
    names = _Names(vars(sys.modules[function.__module__]))
    hints: dict[str, Any] = {}
    for key, parameter in inspect.signature(function).parameters.items():
        hint = parameter.annotation
        if hint is inspect.Parameter.empty:
            continue  # self
        if isinstance(hint, str):
            hint = eval(hint, {}, names)  # our own text, evaluated as Python does
        many = parameter.kind is inspect.Parameter.VAR_KEYWORD
        hints |= get_type_hints(get_args(hint)[0]) if many else {key: hint}
    return hints


def check(value: object, hint: object, where: str) -> None:
    """Raise ArgumentError, starting with ``where``, if a value does not match a type hint."""
    if not fits(value, hint):
        raise ArgumentError(f"{where} = {show(value)} must be {words(hint)}.")
    if not isinstance(value, str | os.PathLike) or _named(value):
        return
    if {kind for kind, _ in _alternatives(hint)} & {Path, os.PathLike}:
        raise ArgumentError(f"{where} = {show(str(value))} has a character that no path can have.")


def fits(value: object, hint: object) -> bool:
    """True if a value matches a type hint; only the beginning of a long collection is checked."""
    return type(value) is hint or any(_is_a(value, *part) for part in _alternatives(hint))


def words(hint: object) -> str:
    """A type hint as source text, such as ``str | None``."""
    return re.sub(r"\w+\.", "", inspect.formatannotation(hint))


@lru_cache(maxsize=1024)
def _alternatives(hint: object) -> tuple[tuple[object, tuple[Any, ...]], ...]:
    """Kind of each part of a hint, with the kind of the elements of a collection."""
    return tuple((_kind(part), get_args(part)) for part in _parts(hint))


def _parts(hint: object) -> tuple[object, ...]:
    return get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)


def _kind(part: object) -> object:
    return NoneType if part is None else get_origin(part) or part


def _is_a(value: object, kind: object, inner: tuple[Any, ...]) -> bool:
    if not isinstance(kind, type):
        return True  # Any, or a variable type
    if kind in (int, float):
        number = Integral if kind is int else Real
        return isinstance(value, number) and not isinstance(value, bool)
    if issubclass(kind, _Absent):
        return kind.__name__ in {item.__name__ for item in type(value).__mro__}
    if kind in _LISTS and isinstance(value, str | bytes):
        return False
    if kind is type and isinstance(value, type) and isinstance(inner[0], TypeVar):
        return issubclass(value, inner[0].__bound__ or object)
    if not isinstance(value, kind):
        return False
    if isinstance(value, Mapping) and kind in (Mapping, dict) and inner:
        pairs = islice(value.items(), LOOKED_AT)
        return all(fits(key, inner[0]) and fits(item, inner[1]) for key, item in pairs)
    return not inner or kind not in _LISTS or _holds(value, inner)


def _holds(value: object, inner: tuple[Any, ...]) -> bool:
    """True if a collection's elements match; an iterator is not consumed."""
    if isinstance(value, Collection):
        hints = repeat(inner[0]) if len(inner) == 1 or Ellipsis in inner else inner
        try:
            return all(map(fits, islice(value, LOOKED_AT), hints))
        except TypeError:
            return False  # an array without dimensions
    return True


def _named(path: str | os.PathLike[str]) -> bool:
    """True if the system accepts that path."""
    try:
        return b"\0" not in os.fsencode(path) and isinstance(os.fspath(path), str)
    except (TypeError, ValueError):
        return False


_LISTS = (Iterable, Collection, Sequence, list, tuple)
