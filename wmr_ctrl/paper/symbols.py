"""The paper's symbols, read from symbols.toml."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files


@dataclass(frozen=True)
class Symbol:
    """A symbol, its meaning, its SI unit, and its name in the code (empty where it has none)."""

    symbol: str
    meaning: str
    unit: str
    code: str


@lru_cache(maxsize=1)
def symbols() -> tuple[Symbol, ...]:
    """All symbols, by subject."""
    text = files("wmr_ctrl.paper").joinpath("symbols.toml").read_text(encoding="utf-8")
    return tuple(Symbol(**row) for row in tomllib.loads(text)["symbol"])
