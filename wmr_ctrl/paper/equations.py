"""The 88 numbered equations, read from equations.toml."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

COUNT = 88
ROLES = ("definition", "identity", "inequality")
STATUSES = ("as printed", "corrected", "stated only")


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


@lru_cache(maxsize=1)
def equations() -> tuple[Equation, ...]:
    """All equations in order."""
    text = files("wmr_ctrl.paper").joinpath("equations.toml").read_text(encoding="utf-8")
    return tuple(Equation(**row) for row in tomllib.loads(text)["equation"])


def equation(number: int) -> Equation:
    """One equation; LookupError for a number that the paper does not have."""
    if not 1 <= number <= COUNT:
        raise LookupError(f"the paper has equations 1 to {COUNT}, not {number}")
    return equations()[number - 1]
