"""The registry of control laws: one module a law, named in one tuple.

A law's module has a docstring, a `Section` of gains, ``build(context) -> System`` whose output is
the generalised force, and ``LAW``, the `Law` of all that.  Other packages add theirs
through the entry-point group ``wmr_ctrl.laws`` (name = law, value = a `Law`).
"""

from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points

from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.core.fields.plugins import load

from .law import Law

NAMES = ("pid", "smc", "mb", "nn", "prox", "kanayama", "pursuit")
GROUP = "wmr_ctrl.laws"


class LawRegistry(Mapping[str, Law]):
    """Laws by name: ours in the order of NAMES, then those of other packages; loaded on demand."""

    def __getitem__(self, name: str) -> Law:
        """The law called ``name``; raises UnknownNameError with the near names."""
        if name in NAMES:
            law: Law = import_module(f"wmr_ctrl.control.laws.{name}").LAW
            return law
        if isinstance(name, str) and name in self.plugins:
            loaded = load(self.plugins[name], GROUP)
            if isinstance(loaded, Law) and loaded.name == name:
                return loaded
            raise ArgumentError(
                f"the entry point {name!r} of the group {GROUP} gives {loaded!r}: it must be a Law "
                f"called {name!r}. Let it point to the value LAW of the law's module."
            )
        raise UnknownNameError("law", name, self)

    def __iter__(self) -> Iterator[str]:
        return iter((*NAMES, *(name for name in self.plugins if name not in NAMES)))

    def __len__(self) -> int:
        return len(tuple(iter(self)))

    def __contains__(self, name: object) -> bool:
        return name in tuple(self)

    @cached_property
    def plugins(self) -> dict[str, EntryPoint]:
        """Entry points of other packages' laws, by name."""
        return {point.name: point for point in entry_points(group=GROUP)}


LAWS = LawRegistry()
