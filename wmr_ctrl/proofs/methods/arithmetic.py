"""Operations that mean the same for exact numbers, balls and solver terms alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

ARITHMETIC: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "inv": lambda a: 1 / a,
    "neg": lambda a: -a,
    "sq": lambda a: a * a,
    "twice": lambda a: 2 * a,
    "assign": lambda a: a,
}
"""By the walker's name of the operation; a backend adds what is its own."""
