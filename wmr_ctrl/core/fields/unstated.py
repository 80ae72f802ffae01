"""Values of fields that nobody stated: derived from other fields, or unknown.

They are numbers, so that graphs have a value for every parameter.  A field that is given one counts
as not stated: it is derived again, and no file states it.
"""

from collections.abc import Iterable
from typing import overload


class Unstated:
    """Value of a field that nobody stated."""

    __slots__ = ()


class Unknown(Unstated):
    """Placeholder of an unknown value; code that reads it must not depend on it."""

    __slots__ = ()


class _Number(float, Unstated):
    __slots__ = ()


class _Vector(tuple[float, ...], Unstated):
    __slots__ = ()


class _UnknownNumber(float, Unknown):
    __slots__ = ()


class _UnknownVector(tuple[float, ...], Unknown):
    __slots__ = ()


@overload
def derived(value: float) -> float: ...
@overload
def derived(value: Iterable[float]) -> tuple[float, ...]: ...
def derived(value: float | Iterable[float]) -> float | tuple[float, ...]:
    """Mark a number or vector as derived from other fields."""
    return _Number(value) if isinstance(value, float | int) else _Vector(value)


def unknown(placeholder: float | tuple[float, ...]) -> float | tuple[float, ...]:
    """Mark a number or vector as the placeholder of an unknown value."""
    if isinstance(placeholder, float):
        return _UnknownNumber(placeholder)
    return _UnknownVector(placeholder)
