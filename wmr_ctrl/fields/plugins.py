"""What other packages add to a registry by entry points."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.fields.problems import show

T = TypeVar("T")


def loaded(group: str, kind: type[T]) -> tuple[T, ...]:
    """The values of a group's entry points, in the order of their names.

    Raises ArgumentError, which names the entry point, for one that is no ``kind`` or cannot be
    loaded.
    """
    points = sorted(entry_points(group=group), key=lambda item: item.name)
    return tuple(_checked(point, group, kind) for point in points)


def _checked(point: EntryPoint, group: str, kind: type[T]) -> T:
    where = f"the entry point {point.name!r} = {point.value!r} of the group {group}"
    try:
        value = point.load()
    except Exception as error:
        raise ArgumentError(
            f"{where} cannot be loaded: {type(error).__name__}: {str(error).rstrip('.')}. Mend or "
            "uninstall the package that has it."
        ) from error
    if not isinstance(value, kind):
        raise ArgumentError(
            f"{where} gives {show(value)}: it must point to a {kind.__name__}. Mend or uninstall "
            "the package that has it."
        )
    return value
