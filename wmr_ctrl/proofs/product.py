"""Functions of the product: which of them a statement's graph holds, and what altering one changes.

A statement is built by calling functions of the product.  Those calls are watched; a function is in
the graph if another result of it gives another graph.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from importlib import import_module
from types import FrameType, FunctionType

import casadi as ca

from wmr_ctrl.model.system import Port

PRODUCT = tuple(
    f"wmr_ctrl.{part}." for part in ("barrier", "control", "guard", "laws", "model", "world")
)
TOOLS = ("wmr_ctrl.model.graph", "wmr_ctrl.model.parameters", "wmr_ctrl.model.system")
"""What carries expressions without computing any."""

Change = Callable[[ca.SX], ca.SX]
CHANGES: Mapping[str, Change] = {
    "* 9/8": lambda x: 1.125 * x,
    "* -1": lambda x: -x,
    "* 8": lambda x: 8 * x,
    "+ 1": lambda x: x + 1,
}
"""Alterations of a function's result."""


def functions_called(build: Callable[[], object]) -> list[str]:
    """Names, ``module:function``, of the product's functions that run while ``build`` runs."""
    names: dict[str, None] = {}

    def watch(frame: FrameType, event: str, _: object) -> None:
        module = frame.f_globals.get("__name__", "")
        if event == "call" and module.startswith(PRODUCT) and module not in TOOLS:
            names.setdefault(f"{module}:{frame.f_code.co_qualname}")

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        build()
    finally:
        sys.setprofile(before)
    return [name for name in names if function_named(name) is not None]


def function_named(name: str) -> FunctionType | None:
    """The function behind ``module:function``, a property's getter included; None for others."""
    module, _, path = name.partition(":")
    try:
        value: object = import_module(module)
    except ModuleNotFoundError:
        return None
    for part in path.split("."):
        value = vars(value).get(part) if hasattr(value, "__dict__") else None
    if isinstance(value, property):
        value = value.fget
    if isinstance(value, cached_property):
        value = value.func
    return value if isinstance(value, FunctionType) and value.__closure__ is None else None


@contextmanager
def altered(name: str, change: Change) -> Iterator[None]:
    """For a time every caller of the function gets its results changed."""
    function = function_named(name)
    assert function is not None, name
    code, defaults, named = function.__code__, function.__defaults__, function.__kwdefaults__
    original = FunctionType(code, function.__globals__, "original", defaults)
    original.__kwdefaults__ = named
    place = f"_altered {name}"
    function.__globals__[place] = lambda *a, **k: changed(original(*a, **k), change)
    function.__defaults__ = function.__kwdefaults__ = None
    function.__code__ = _stand_in.__code__.replace(co_names=(place,))
    try:
        yield
    finally:
        function.__code__ = code
        function.__defaults__, function.__kwdefaults__ = defaults, named
        del function.__globals__[place]


def _stand_in(*args: object, **named: object) -> object:
    return _altered(*args, **named)  # type: ignore[name-defined]  # noqa: F821


def changed(value: object, change: Change) -> object:
    """A result with ``change`` made to every expression in it."""
    if isinstance(value, ca.SX):
        return change(value)
    if isinstance(value, Port):
        return value
    if isinstance(value, tuple | list):
        parts = [changed(part, change) for part in value]
        return parts if isinstance(value, list) else tuple(parts)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: changed(getattr(value, f.name), change)
                                 for f in fields(value) if f.init})  # fmt: skip
    return value
