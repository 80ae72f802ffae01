"""The registry of references: one line each.

Other packages add theirs through the entry-point group ``wmr_ctrl.references`` (name = kind,
value = a `ReferenceKind`).
"""

from collections.abc import Iterator, Mapping
from functools import cached_property

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.plugins import loaded

from . import rounded_square, waypoints
from .curves import CIRCLE, LEMNISCATE, LINE, STOP_AND_GO
from .kind import Reference, ReferenceKind

OURS = (CIRCLE, LINE, LEMNISCATE, rounded_square.KIND, STOP_AND_GO, waypoints.KIND)
GROUP = "wmr_ctrl.references"


class ReferenceRegistry(Mapping[str, ReferenceKind]):
    """Kinds by name: ours, then those of other packages."""

    @cached_property
    def plugins(self) -> tuple[ReferenceKind, ...]:
        """Kinds of other packages."""
        foreign = loaded(GROUP, ReferenceKind)
        names = [item.name for item in (*OURS, *foreign)]
        for name in (name for name in names if names.count(name) > 1):
            raise ArgumentError(
                f"two references are called {name!r}. The author of the one in another package "
                "must rename it."
            )
        return foreign

    def __getitem__(self, name: str) -> ReferenceKind:
        return {item.name: item for item in (*OURS, *self.plugins)}[name]

    def __iter__(self) -> Iterator[str]:
        return (item.name for item in (*OURS, *self.plugins))

    def __len__(self) -> int:
        return len(OURS) + len(self.plugins)

    def of(self, reference: Reference) -> ReferenceKind | None:
        """Return the kind that the section ``reference`` belongs to."""
        same = (item for item in self.values() if type(reference) is item.section)
        return next(same, None)


REFERENCES = ReferenceRegistry()
