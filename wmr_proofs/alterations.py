"""Find the product's functions in a statement's graph, by altering their results.

A statement is built by calling functions of the product.  These calls are recorded; a function is
in the graph if another result of it gives another graph.
"""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import fields, is_dataclass, replace
from functools import cached_property, partial
from importlib import import_module
from itertools import chain
from operator import mul
from types import FrameType, FunctionType
from typing import Any

from casadi import SX

from wmr_ctrl.world.model.system import Port, System

from .claim import CLAIMED, Claim
from .claims import forget
from .statement import Statement
from .traced import Traced

PRODUCT = (
    "wmr_ctrl.control.",
    "wmr_ctrl.world.",
    "wmr_proofs.paper_functions",
    "wmr_proofs.paper_barrier",
)
TOOLS = ("wmr_ctrl.world.model.graph", "wmr_ctrl.world.model.system")
"""Modules that only carry expressions."""

Change = Callable[[Any], Any]


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
    """The function called ``module:function``, or a property's getter; None for others."""
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
    """Context in which every caller of the function receives altered results."""
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
    """A result with ``change`` applied to every expression in it."""
    if isinstance(value, SX | Traced):
        return change(value)
    if isinstance(value, Port):
        return value
    if isinstance(value, tuple | list):
        parts = [changed(part, change) for part in value]
        if all(new is old for new, old in zip(parts, value, strict=True)):
            return value
        return parts if isinstance(value, list) else tuple(parts)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{f.name: changed(getattr(value, f.name), change)
                                 for f in fields(value) if f.init})  # fmt: skip
    return value


def functions_of(claim: Claim, first: Sequence[str] = ()) -> tuple[str, ...]:
    """Functions of the product that the claim's graph contains.

    A called function is contained if its results, multiplied by a number, make another graph.  Many
    are tried together, with different numbers: if the graph is unchanged, it contains none of them.
    A function is not contained if the statement cannot be built with its results altered.  For
    functions in ``first``, which were contained before, the test is whether the graph still reads
    their results.
    """
    before: list[Statement | None] = []
    forget()
    calls = functions_called(lambda: before.append(built(claim)))
    if before[0] is None:
        return ()
    held = _read(claim, [name for name in calls if name in first])
    factors = {name: 1.125 + k / 64 for k, name in enumerate(calls) if name not in held}
    held |= _held(claim, factors, before[0].graph.digest)
    return tuple(name for name in calls if name in held)


def _read(claim: Claim, names: Sequence[str]) -> set[str]:
    """Functions whose results the graph reads: each result is multiplied by a symbol."""
    marks = {name: SX.sym(f"result {k}") for k, name in enumerate(names)}
    changes = {name: partial(_marked, mark) for name, mark in marks.items()}
    statement = built(claim, changes, marks) if marks else None
    parts = (statement, *statement.parts.values()) if statement else ()
    return set(marks) & set(chain.from_iterable(part.graph.input_names for part in parts))


def _held(claim: Claim, factors: Mapping[str, float], digest: str) -> set[str]:
    changes = {name: partial(mul, factor) for name, factor in factors.items()}
    statement = built(claim, changes) if factors else None
    if statement is not None and statement.graph.digest == digest:
        return set()
    if len(factors) < 2:
        return set(factors) if statement is not None else set()
    rows = list(factors.items())
    halves = rows[: len(rows) // 2], rows[len(rows) // 2 :]
    return set().union(*(_held(claim, dict(half), digest) for half in halves))


def _marked(mark: SX, value: Any) -> Any:
    if isinstance(value, Traced):
        return Traced(float(value), mark * value.expr, value.trace)
    return mark * value


def built(
    claim: Claim, changes: Mapping[str, Change] = {}, marks: Mapping[str, SX] = {}
) -> Statement | None:
    """The claim's statement with altered functions; None if it cannot be built so.

    ``marks``: symbols of the alterations, by their names in its graph.
    """
    forget()
    try:
        with ExitStack() as stack:
            for name, change in changes.items():
                stack.enter_context(altered(name, change))
            if marks:
                stack.enter_context(_open_systems())
            statement = claim.statement(CLAIMED) if claim.statement else None
            if statement and marks:
                statement = _with_marks(statement, marks)
            _ = statement.graph if statement else None
    except (ValueError, RuntimeError, TypeError, NotImplementedError):
        return None
    finally:
        forget()
    return statement


def _with_marks(statement: Statement, marks: Mapping[str, SX]) -> Statement:
    parts = {key: _with_marks(part, marks) for key, part in statement.parts.items()}
    return replace(statement, symbols={**statement.symbols, **marks}, parts=parts)


@contextmanager
def _open_systems() -> Iterator[None]:
    """Context in which a System may read symbols that belong to no port."""
    check = System.__post_init__

    def unchecked(self: System) -> None:
        pass

    System.__post_init__ = unchecked  # type: ignore[method-assign]
    try:
        yield
    finally:
        System.__post_init__ = check  # type: ignore[method-assign]
