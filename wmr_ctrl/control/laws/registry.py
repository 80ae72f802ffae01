"""The registry of control laws: one module per law, named in one tuple.

A law's module has a docstring, a `Section` of gains, ``build(context) -> System`` whose output is
the generalised force, and ``LAW``, the `Law` that combines them.  Other packages add theirs through
the entry-point group ``wmr_ctrl.laws`` (name = law, value = a `Law`), and users give a law or its
file (`given`).
"""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points

from wmr_ctrl.core.errors import ArgumentError, ScenarioError, UnknownNameError
from wmr_ctrl.core.fields.arguments import check_fields
from wmr_ctrl.core.fields.plugins import blamed, load
from wmr_ctrl.core.fields.section import Section, quantities

from .law import Law

NAMES = ("pid", "smc", "mb", "nn", "prox", "kanayama", "pursuit")
GROUP = "wmr_ctrl.laws"
RESERVED = (
    *("all", "kinematics", "guard", "filter", "reference", "plant", "corridor"),
    *("closed-loop", "ssp", "modelica", "simulink", "law"),
)
"""Words that mean something else where a law may be named."""
_REMEDY = "A law in a file is named by its path, such as ./my_law.py."


class LawRegistry(Mapping[str, Law]):
    """Laws by name: built-in laws in the order of NAMES, given laws, laws of other packages."""

    def __init__(self) -> None:
        self.given: dict[str, Law] = {}
        self.files: dict[str, str] = {}

    def __getitem__(self, name: str) -> Law:
        """The law called ``name``; raises UnknownNameError with the near names."""
        if name in NAMES:
            law: Law = import_module(f"wmr_ctrl.control.laws.{name}").LAW
            return law
        if name in self.given:
            return self.given[name]
        if isinstance(name, str) and name in self.plugins:
            loaded = load(self.plugins[name], GROUP)
            if isinstance(loaded, Law) and loaded.name == name:
                check_law(loaded, f"the entry point {name!r} of the group {GROUP}")
                return loaded
            raise ArgumentError(
                f"the entry point {name!r} of the group {GROUP} gives {loaded!r}: it must be a Law "
                f"called {name!r}. Let it point to the value LAW of the law's module."
            )
        raise UnknownNameError("law", name, self, _REMEDY)

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys((*NAMES, *self.given, *self.plugins)))

    def __len__(self) -> int:
        return len(tuple(iter(self)))

    def __contains__(self, name: object) -> bool:
        return name in tuple(self)

    @cached_property
    def plugins(self) -> dict[str, EntryPoint]:
        """Entry points of other packages' laws, by name."""
        return {point.name: point for point in entry_points(group=GROUP)}

    def spelled(self, name: str) -> str:
        """The law as written on a command line: its file, else its name."""
        return self.files.get(name, name)

    def add(self, law: Law, where: str = "") -> str:
        """Register a law and return its name; it replaces one that was added before.

        ``where``: its definition, for errors.  Raises ArgumentError for a law that is invalid or
        has the name of a built-in one.
        """
        if law.name in NAMES:
            ours = import_module(f"wmr_ctrl.control.laws.{law.name}").LAW
            if law is ours:
                return law.name
            place = f"{where}: " if where else ""
            raise ArgumentError(
                f"{place}the law is called {law.name!r}, which is the name of a law of wmr_ctrl. "
                "Give it another name: the first argument of Law(...)."
            )
        check_law(law, where)
        self.given[law.name] = law
        self.files.pop(law.name, None)
        return law.name


def check_law(law: Law, where: str = "") -> None:
    """Raise ArgumentError, beginning with ``where``, unless a law's fields are valid."""
    place = f"{where}: " if where else ""
    try:
        check_fields(law)
    except ArgumentError as error:
        raise ArgumentError(f"{place}{error}") from None
    if not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", law.name) or law.name in RESERVED:
        raise ArgumentError(
            f"{place}a law cannot be called {law.name!r}. Take a name of letters, digits and "
            f"underscores that is none of {', '.join(RESERVED)}."
        )
    if not issubclass(law.gains, Section):
        raise ArgumentError(f"{place}the gains of the law {law.name!r} must be a Section.")
    known = dict(quantities(law.gains))
    if unknown := [name for name in law.tuned if name not in known]:
        raise ArgumentError(
            f"{place}tuned names {unknown[0]!r}, which is none of the gains of {law.name!r}: "
            f"{', '.join(known) or 'it has none'}."
        )


def blamed_law(law: Law, function: Callable[..., object]) -> AbstractContextManager[None]:
    """Context for a function of another author's law: its errors name file and line.

    A ScenarioError raised by the law is passed on unchanged.
    """
    if law.name in NAMES:
        return nullcontext()
    return blamed(
        f"the law {law.name!r} fails", "Mend the law.", (ScenarioError, ArgumentError), function
    )


LAWS = LawRegistry()
