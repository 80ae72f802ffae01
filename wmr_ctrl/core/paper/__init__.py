"""The paper as data: numbered equations, symbols, citation."""

from dataclasses import dataclass
from functools import lru_cache

from wmr_ctrl.core.data import data

CITATION = (
    "Z. Chen, Y. Liu, W. He, H. Qiao, and H. Ji, “Adaptive-Neural-Network-Based Trajectory "
    "Tracking Control for a Nonholonomic Wheeled Mobile Robot With Velocity Constraints,” "
    "IEEE Transactions on Industrial Electronics, vol. 68, no. 6, pp. 5057–5067, June 2021, "
    "doi:10.1109/TIE.2020.2989711."
)
EVALUATIONS = 10_000
"""Evaluations of a law that were timed."""
PAPER_TIMES = {"pid": 0.4056, "smc": 2.0662, "mb": 0.3875, "nn": 1.4294}
"""Time that so many evaluations of each law took the authors [s]."""


@dataclass(frozen=True)
class Equation:
    """One numbered equation.

    ``home`` is where it lives: ``module:function``, or a module for what needs no function.
    """

    number: int
    title: str
    role: str
    home: str
    status: str
    note: str


@dataclass(frozen=True)
class Symbol:
    """A symbol, its meaning, its SI unit, and its name in the code (empty where it has none)."""

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
