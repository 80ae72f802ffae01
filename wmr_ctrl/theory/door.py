"""Access to wmr_proofs, which needs python-flint and z3, and so is imported only by name."""

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from wmr_ctrl.core.errors import install, library

EXTRA = "proofs"
SOLVERS = ("flint", "z3")
"""Packages of the extra."""
LEFT_OUT = f"nothing is proved or certified here: {install(EXTRA)}"
"""Sentence of commands that go on without these packages."""


def is_open() -> bool:
    """True if wmr_proofs and the packages of the extra are installed."""
    return all(find_spec(name) is not None for name in ("wmr_proofs", *SOLVERS))


def proofs(module: str = "") -> ModuleType:
    """A module of wmr_proofs, by default the package itself.

    Raises MissingExtraError, which names the extra, if a package is missing.
    """
    for name in ("wmr_proofs", *SOLVERS):
        library(name, EXTRA)
    return import_module(f"wmr_proofs.{module}".rstrip("."))
