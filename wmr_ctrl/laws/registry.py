"""The registry of control laws: one module a law, named in one tuple.

A law's module has a docstring (its first line is the title), a frozen dataclass ``Gains`` and
``build(scenario) -> System`` whose output is the generalised force.  Other packages add theirs
through the entry-point group ``wmr_ctrl.laws`` (name = law, value = module).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType

from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.model.system import System
from wmr_ctrl.scenario import Scenario

NAMES = ("pid", "smc", "mb", "nn", "prox")


@dataclass(frozen=True)
class Law:
    """A control law: name, title, gains' dataclass, builder and its module's documentation."""

    name: str
    title: str
    gains: type
    build: Callable[[Scenario], System]
    doc: str


class Registry(Mapping[str, Law]):
    """Laws by name: ours in the order of NAMES, then those of other packages; loaded on demand."""

    def __getitem__(self, name: str) -> Law:
        """The law called ``name``; raises UnknownNameError with the near names."""
        if name in NAMES:
            return law_from(name, import_module(f"wmr_ctrl.laws.{name}"))
        if name in self._plugins:
            return law_from(name, self._plugins[name].load())
        raise UnknownNameError("law", name, self)

    def __iter__(self) -> Iterator[str]:
        """Names of all laws."""
        return iter((*NAMES, *(name for name in self._plugins if name not in NAMES)))

    def __len__(self) -> int:
        """Number of laws."""
        return len(tuple(iter(self)))

    def __contains__(self, name: object) -> bool:
        """Whether a law has this name."""
        return name in tuple(self)

    @cached_property
    def _plugins(self) -> dict[str, EntryPoint]:
        return {point.name: point for point in entry_points(group="wmr_ctrl.laws")}


def law_from(name: str, module: ModuleType) -> Law:
    """A Law from a module of the shape described above."""
    doc = (module.__doc__ or name).strip()
    return Law(name, doc.splitlines()[0].rstrip("."), module.Gains, module.build, doc)


LAWS = Registry()
