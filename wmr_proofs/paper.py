"""The paper's numbered equations and its symbols, as data."""

from dataclasses import dataclass
from functools import lru_cache

from wmr_ctrl.core.data import data


@dataclass(frozen=True)
class Equation:
    """One numbered equation.

    ``home`` is its place in the code: ``module:function``, or a module if it needs no function.
    """

    number: int
    title: str
    role: str
    home: str
    status: str
    note: str


@dataclass(frozen=True)
class Symbol:
    """A symbol, its meaning, its SI unit, and its name in the code (empty if it has none)."""

    symbol: str
    meaning: str
    unit: str
    code: str


@lru_cache(maxsize=1)
def equations() -> tuple[Equation, ...]:
    """All equations in order."""
    return tuple(Equation(**row) for row in data(__package__, "equations.toml")["equation"])


@lru_cache(maxsize=1)
def symbols() -> tuple[Symbol, ...]:
    """All symbols, by subject."""
    return tuple(Symbol(**row) for row in data(__package__, "symbols.toml")["symbol"])
