"""Registry entries from other packages' entry points, and errors that name their source."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from wmr_ctrl.core.errors import ArgumentError, WmrError

from .problems import show

T = TypeVar("T")
_REMEDY = "Mend or uninstall the package that has it."


@contextmanager
def blamed(
    what: str, remedy: str, passing: tuple[type[Exception], ...] = (WmrError,)
) -> Iterator[None]:
    """Turn an error in code of another package into an ArgumentError that begins with ``what``.

    Those of ``passing`` say enough to a user as they are.
    """
    try:
        yield
    except passing:
        raise
    except Exception as error:
        said = str(error).rstrip(".")
        raise ArgumentError(f"{what}: {type(error).__name__}: {said}. {remedy}") from error


def load(point: EntryPoint, group: str) -> object:
    """The value of an entry point; raises ArgumentError, which names it, where it has none."""
    with blamed(f"{_named(point, group)} cannot be loaded", _REMEDY, passing=()):
        return point.load()


def loaded(group: str, kind: type[T]) -> tuple[T, ...]:
    """The values of a group's entry points, in the order of their names.

    Raises ArgumentError, which names the entry point, for one that is no ``kind`` or cannot be
    loaded.
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
