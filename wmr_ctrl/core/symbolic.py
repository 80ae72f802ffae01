"""CasADi, loaded when it is first used.

A scenario knows the kinds of its references and effects, whose files also contain graphs.  A worker
that only runs compiled code reads scenarios and must not wait for CasADi.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING


class _OnFirstUse:
    """Placeholder of a module, which is imported when one of its names is first read."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> object:
        value = getattr(import_module(self._name), name)
        setattr(self, name, value)
        return value


if TYPE_CHECKING:
    import casadi as ca
else:
    ca = _OnFirstUse("casadi")

__all__ = ["ca"]
